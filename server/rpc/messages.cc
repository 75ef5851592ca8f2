#include "server/rpc/messages.h"

#include <google/protobuf/io/zero_copy_stream.h>
#include <grpcpp/support/proto_buffer_reader.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

// chosen: names, uids and tokens of a request take less than a kilobyte.
constexpr std::size_t kMaxStreamRequestBytes = 64 << 10;

// Steps of a WorkBudget that a message takes besides its fields: about 0.1 us.
constexpr std::size_t kStepsOfMessage = 4;

// The bytes of a request, which end when the budget does. A slice of gRPC may have megabytes.
class BudgetedBytes final : public google::protobuf::io::ZeroCopyInputStream {
 public:
  BudgetedBytes(google::protobuf::io::ZeroCopyInputStream& bytes, WorkBudget& budget)
      : bytes_(bytes), budget_(budget) {}

  bool Next(const void** data, int* size) override {
    if (!bytes_.Next(data, size)) return false;
    if (*size > kMaxPieceBytes) {
      bytes_.BackUp(*size - kMaxPieceBytes);
      *size = kMaxPieceBytes;
    }
    return !budget_.MustEndAfter(static_cast<std::size_t>(*size));
  }
  void BackUp(int count) override { bytes_.BackUp(count); }
  bool Skip(int count) override { return bytes_.Skip(count); }
  std::int64_t ByteCount() const override { return bytes_.ByteCount(); }

 private:
  static constexpr int kMaxPieceBytes = 32 << 10;

  google::protobuf::io::ZeroCopyInputStream& bytes_;
  WorkBudget& budget_;
};

// Like Message::DiscardUnknownFields, but checks the budget. Messages are nested at most 100 deep,
// which is the limit of parsing.
void DropUnknownFields(google::protobuf::Message& message, WorkBudget& budget) {
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  if (!reflection.GetUnknownFields(message).empty()) {
    reflection.MutableUnknownFields(&message)->Clear();
  }
  std::vector<const google::protobuf::FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const auto* field : fields) {
    if (field->cpp_type() != google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (!field->is_repeated()) {
      DropUnknownFields(*reflection.MutableMessage(&message, field), budget);
      continue;
    }
    for (int i = 0; i < reflection.FieldSize(message, field); ++i) {
      if (budget.MustEndAfter(kStepsOfMessage)) return;
      DropUnknownFields(*reflection.MutableRepeatedMessage(&message, field, i), budget);
    }
  }
}

}  // namespace

absl::Status ParseRequest(grpc::ByteBuffer& bytes, google::protobuf::Message* request,
                          WorkBudget* budget) {
  const bool is_parsed = [&] {
    grpc::ProtoBufferReader reader(&bytes);
    BudgetedBytes budgeted(reader, *budget);
    return reader.status().ok() && request->ParseFromZeroCopyStream(&budgeted);
  }();
  bytes.Clear();
  if (is_parsed) DropUnknownFields(*request, *budget);
  if (HasEnded(budget)) return budget->status();
  return is_parsed ? absl::OkStatus()
                   : MalformedRequest(MethodWithRequest(*request->GetDescriptor()));
}

absl::Status CheckStreamRequestSize(const grpc::ByteBuffer& bytes) {
  const std::size_t size = bytes.Length();
  if (size <= kMaxStreamRequestBytes) return absl::OkStatus();
  return MakeError(
      absl::StatusCode::kInvalidArgument,
      absl::StrCat("the request has ", size, " bytes, must have at most ", kMaxStreamRequestBytes),
      {.reason = "REQUEST_TOO_LARGE"});
}

absl::Status MalformedRequest(const std::string& method) {
  const std::string name = absl::StrReplaceAll(method.substr(1), {{"/", "."}});
  const auto* known = google::protobuf::DescriptorPool::generated_pool()->FindMethodByName(name);
  const std::string type = known == nullptr ? "" : known->input_type()->full_name();
  return MakeError(
      absl::StatusCode::kInvalidArgument,
      absl::StrCat(method, ": the request is no valid ", type, " message"),
      {.reason = "MALFORMED_REQUEST", .metadata = {{"method", method}, {"type", type}}});
}

std::string MethodWithRequest(const google::protobuf::Descriptor& request) {
  const google::protobuf::FileDescriptor& file = *request.file();
  for (int i = 0; i < file.service_count(); ++i) {
    for (int k = 0; k < file.service(i)->method_count(); ++k) {
      const google::protobuf::MethodDescriptor& method = *file.service(i)->method(k);
      if (method.input_type() == &request) {
        return absl::StrCat("/", file.service(i)->full_name(), "/", method.name());
      }
    }
  }
  return "/" + request.full_name();
}

}  // namespace cwm::server
