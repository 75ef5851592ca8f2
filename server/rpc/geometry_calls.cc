#include "server/rpc/geometry_calls.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "proto/transfer/chunks.h"
#include "proto/transfer/mesh_bytes.h"
#include "proto/transfer/sha256.h"
#include "server/core/error.h"
#include "server/rpc/status_conversion.h"
#include "server/wire/numbers.h"

namespace cwm::server {
namespace {

// No more than three vertices a triangle make sense.
constexpr std::int64_t kMostBytesPerTriangle = 3 * kVertexBytes + kTriangleBytes;

absl::Status CheckTriangleCount(const std::string& bytes, const Limits& limits) {
  const auto counts = ReadMeshCounts(bytes);
  if (!counts.ok()) return absl::OkStatus();  // Put says what is wrong
  return CheckRange(counts->triangles, {0, limits.max_mesh_triangles},
                    FieldPath().Field("chunk").Field("data").Field("triangle_count"));
}

BlobFormat FormatOf(const v1::WriteGeometryRequest::Header& header) {
  return header.format() == v1::GEOMETRY_FORMAT_LABELS_U32 ? BlobFormat::kLabelsU32
                                                           : BlobFormat::kMeshF64;
}

}  // namespace

ReadGeometryCall::ReadGeometryCall(Runtime& runtime, const v1::ReadGeometryRequest& request)
    : runtime_(runtime) {
  const auto work = [this, hash = request.hash()] { Open(hash); };
  if (runtime_.reads.TryPush(work)) return;
  Finish(ToGrpcStatus(Overloaded("the server has more work than it can take", "QUEUE_FULL")));
}

void ReadGeometryCall::Open(const std::string& hash) {
  const CallWork work = [this, &hash](const CallContext&) {
    auto blob = runtime_.application.geometry.Get(hash);
    if (!blob.ok()) return blob.status();
    blob_ = *std::move(blob);
    return absl::OkStatus();
  };
  const absl::Status status = RunGuarded(work, {});
  if (!status.ok()) return Finish(ToGrpcStatus(status));
  WriteNext();
}

void ReadGeometryCall::WriteNext() {
  const std::string& bytes = blob_->bytes;
  message_.set_format(blob_->format == BlobFormat::kMeshF64 ? v1::GEOMETRY_FORMAT_MESH_F64
                                                            : v1::GEOMETRY_FORMAT_LABELS_U32);
  message_.set_total_bytes(static_cast<std::int64_t>(bytes.size()));
  message_.set_offset(static_cast<std::int64_t>(offset_));
  const std::size_t count = std::min<std::size_t>(kMaxChunkBytes, bytes.size() - offset_);
  message_.set_data(bytes.data() + offset_, count);
  offset_ += count;
  message_.set_done(offset_ == bytes.size());
  StartWrite(&message_);
}

void ReadGeometryCall::OnWriteDone(bool ok) {
  if (!ok) return Finish(ToGrpcStatus(CallCancelled()));
  if (message_.done()) return Finish(grpc::Status::OK);
  WriteNext();
}

WriteGeometryCall::WriteGeometryCall(Runtime& runtime, v1::WriteGeometryResponse* response)
    : runtime_(runtime), response_(response) {
  StartRead(&message_);
}

void WriteGeometryCall::OnReadDone(bool ok) {
  const absl::Status status = ok ? Take(message_) : CheckEnd();
  if (!status.ok()) return Finish(ToGrpcStatus(status));
  if (!ok) {
    return Enqueue([this] {
      const CallWork work = [this](const CallContext&) { return Store(); };
      Finish(ToGrpcStatus(RunGuarded(work, {})));  // *this may be gone after it
    });
  }
  if (message_.has_header() && !header_.hash().empty()) return Enqueue([this] { LookUp(); });
  StartRead(&message_);
}

// Bytes that are known need not travel.
void WriteGeometryCall::LookUp() {
  bool known = false;
  const CallWork work = [this, &known](const CallContext&) {
    auto is_known = IsKnown();
    if (is_known.ok()) known = *is_known;
    return is_known.status();
  };
  const absl::Status status = RunGuarded(work, {});
  if (known || !status.ok()) return Finish(ToGrpcStatus(status));
  StartRead(&message_);
}

absl::StatusOr<bool> WriteGeometryCall::IsKnown() {
  GeometryStore& store = runtime_.application.geometry;
  const std::string hash = absl::AsciiStrToLower(header_.hash());
  const auto blob = store.Get(hash);
  if (!blob.ok()) return false;
  const auto size = static_cast<std::int64_t>((*blob)->bytes.size());
  if (header_.total_bytes() != size) {
    return InvalidField("header.total_bytes", absl::StrCat("is ", header_.total_bytes(),
                                                           ", must be ", size, " for that hash"));
  }
  auto stored = store.PutAgain(FormatOf(header_), hash);
  if (absl::IsNotFound(stored.status())) return false;  // gone just now
  if (!stored.ok()) return stored.status();
  Reply(*stored);
  return true;
}

absl::Status WriteGeometryCall::Take(const v1::WriteGeometryRequest& message) {
  const FieldPath root;
  switch (message.what_case()) {
    case v1::WriteGeometryRequest::kHeader:
      return TakeHeader(message.header());
    case v1::WriteGeometryRequest::kChunk:
      if (!upload_) return root.Field("chunk").Error("came before the header, must come after it");
      return upload_->Append(message.chunk().offset(), message.chunk().data(), root.Field("chunk"));
    case v1::WriteGeometryRequest::WHAT_NOT_SET:
      break;
  }
  return root.Field("what").Error("is absent, must be one of header, chunk");
}

absl::Status WriteGeometryCall::TakeHeader(const v1::WriteGeometryRequest::Header& header) {
  const FieldPath root;
  const FieldPath path = root.Field("header");
  if (upload_) return path.Error("came twice, must come once");
  if (!v1::GeometryFormat_IsValid(header.format())) {
    return path.Field("format").Error(
        absl::StrCat("is ", static_cast<int>(header.format()), ", must be a known GeometryFormat"));
  }
  const Limits& limits = runtime_.application.limits;
  const std::int64_t largest_mesh =
      kMeshCountsBytes + limits.max_mesh_triangles * kMostBytesPerTriangle;
  const std::int64_t most = std::min(largest_mesh, limits.max_geometry_bytes);
  auto status = CheckRange(header.total_bytes(), {1, most}, path.Field("total_bytes"));
  if (!status.ok()) return status;
  header_ = header;
  upload_.emplace(header.total_bytes(), runtime_);
  return absl::OkStatus();
}

absl::Status WriteGeometryCall::CheckEnd() const {
  if (stop_.stop_requested()) return CallCancelled();
  if (!upload_) return InvalidField("header", "is absent, must come first");
  return upload_->CheckComplete(FieldPath().Field("end of the stream"));
}

void WriteGeometryCall::Enqueue(std::function<void()> work) {
  if (runtime_.writes.TryPush(std::move(work))) return;
  Finish(ToGrpcStatus(Overloaded("the server has more work than it can take", "QUEUE_FULL")));
}

absl::Status WriteGeometryCall::Store() {
  Application& application = runtime_.application;
  const std::string given_hash = absl::AsciiStrToLower(header_.hash());
  if (!given_hash.empty()) {
    const std::string actual = Sha256Hex(upload_->bytes());
    if (actual != given_hash) {
      return InvalidField("header.hash", absl::StrCat("is ", given_hash, ", must be ", actual,
                                                      " (SHA-256 of all bytes)"));
    }
  }
  const BlobFormat format = FormatOf(header_);
  if (format == BlobFormat::kMeshF64) {
    auto status = CheckTriangleCount(upload_->bytes(), application.limits);
    if (!status.ok()) return status;
  }
  auto stored = application.geometry.Put(format, upload_->Take());
  if (!stored.ok()) return stored.status();
  Reply(*stored);
  return absl::OkStatus();
}

void WriteGeometryCall::Reply(const GeometryStore::Stored& stored) {
  response_->set_hash(stored.hash);
  response_->set_already_known(stored.already_known);
}

}  // namespace cwm::server
