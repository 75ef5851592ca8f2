#include "tests/benchmarks/server/held_call.h"

#include <zlib.h>

#include <array>

namespace cwm::benchmarks {
namespace {

constexpr std::int64_t kPrefixBytes = 5;

std::int64_t CompressedBytes(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string compressed(size, '\0');
  compress(reinterpret_cast<Bytef*>(compressed.data()), &size,
           reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  return static_cast<std::int64_t>(size);
}

}  // namespace

std::int64_t WireBytes(const CallPlan& plan) {
  std::int64_t sum = 0;
  const std::string* last = nullptr;
  std::int64_t last_bytes = 0;
  for (const std::string& message : plan.messages) {
    if (last == nullptr || *last != message) {  // many plans repeat one message
      last = &message;
      last_bytes =
          plan.compresses ? CompressedBytes(message) : static_cast<std::int64_t>(message.size());
    }
    sum += kPrefixBytes + last_bytes;
  }
  return sum;
}

HeldCall::HeldCall(const std::shared_ptr<grpc::Channel>& channel, CallPlan plan)
    : plan_(std::move(plan)), wire_bytes_(WireBytes(plan_)), stub_(channel) {
  for (const auto& [key, value] : plan_.metadata) context_.AddMetadata(key, value);
  if (plan_.compresses) context_.set_compression_algorithm(GRPC_COMPRESS_GZIP);
  stub_.PrepareBidiStreamingCall(&context_, "/" + plan_.method, {}, this);
  SendNext();
  if (plan_.reads) StartRead(&incoming_);
  StartCall();
}

HeldCall::~HeldCall() {
  Cancel();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return done_; });
}

void HeldCall::Cancel() { context_.TryCancel(); }

bool HeldCall::WaitUntilDone(std::chrono::milliseconds limit) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, limit, [this] { return done_; });
}

bool HeldCall::WaitUntilSent(std::chrono::milliseconds limit) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, limit, [this] { return sent_ || done_; });
}

std::string HeldCall::Outcome() const {
  const std::lock_guard lock(mutex_);
  return done_ ? CodeName(status_.error_code()) : "open";
}

grpc::Status HeldCall::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void HeldCall::SendNext() {
  if (next_ < plan_.messages.size()) {
    const std::string& message = plan_.messages[next_++];
    const grpc::Slice slice(message.data(), message.size());
    outgoing_ = grpc::ByteBuffer(&slice, 1);
    return StartWrite(&outgoing_);
  }
  if (plan_.half_closes) StartWritesDone();
  const std::lock_guard lock(mutex_);
  sent_ = true;
  changed_.notify_all();
}

void HeldCall::OnWriteDone(bool ok) {
  if (ok) SendNext();
}

void HeldCall::OnReadDone(bool ok) {
  if (ok) StartRead(&incoming_);
}

void HeldCall::OnDone(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  status_ = status;
  done_ = true;
  changed_.notify_all();
}

std::string CodeName(grpc::StatusCode code) {
  static constexpr std::array<const char*, 17> kNames = {
      "OK",        "CANCELLED",      "UNKNOWN",           "INVALID_ARGUMENT", "DEADLINE",
      "NOT_FOUND", "ALREADY_EXISTS", "PERMISSION_DENIED", "EXHAUSTED",        "FAILED_PRECOND",
      "ABORTED",   "OUT_OF_RANGE",   "UNIMPLEMENTED",     "INTERNAL",         "UNAVAILABLE",
      "DATA_LOSS", "UNAUTHENTICATED"};
  const auto index = static_cast<std::size_t>(code);
  return index < kNames.size() ? kNames[index] : std::to_string(index);
}

}  // namespace cwm::benchmarks
