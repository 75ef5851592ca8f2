#include "server/rpc/back_up_call.h"

#include <algorithm>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/transfer/chunks.h"
#include "server/core/error.h"
#include "server/rpc/messages.h"
#include "server/rpc/status_conversion.h"

namespace cwm::server {
namespace {

// chosen: bytes hashed in one step, about 10 ms on a queue that robots' files wait for, too.
constexpr std::int64_t kMaxHashedInStep = 16 * kMaxChunkBytes;
// chosen: a full queue of robots' files has advanced by then.
constexpr auto kPauseOfFullQueue = std::chrono::milliseconds(100);

absl::Status ReadFailed(const BackupFile& file) {
  return MakeError(absl::StatusCode::kUnavailable,
                   absl::StrCat("cannot read ", file.path, " of the backup"),
                   {.reason = "STORE_FAILED"});
}

}  // namespace

BackUpCall* BackUpCall::Start(grpc::CallbackServerContext& context, Runtime& runtime,
                              const grpc::ByteBuffer* request, std::atomic<bool>& is_under_way) {
  const std::shared_ptr<BackUpCall> call(new BackUpCall(runtime, context, is_under_way));
  call->self_ = call;
  const absl::Status begun = call->Begin(request);
  if (!begun.ok()) call->End(begun);
  return call.get();
}

BackUpCall::BackUpCall(Runtime& runtime, grpc::CallbackServerContext& context,
                       std::atomic<bool>& is_under_way)
    : runtime_(runtime), context_(context), is_under_way_(is_under_way) {}

BackUpCall::~BackUpCall() { Release(); }

void BackUpCall::Release() {
  backup_.reset();
  if (std::exchange(holds_place_, false)) is_under_way_ = false;
}

absl::Status BackUpCall::Begin(const grpc::ByteBuffer* request) {
  if (absl::Status serving = runtime_.CheckServing(); !serving.ok()) return serving;
  v1::BackUpRequest parsed;
  if (absl::Status status = ParseStreamRequest(request, &parsed); !status.ok()) return status;
  StoreAdmin* const store = runtime_.application.store_admin;
  if (store == nullptr) {
    return MakeError(absl::StatusCode::kFailedPrecondition,
                     "the server keeps its worlds in memory; cwm-server --store sqlite:PATH keeps "
                     "them in a store that can be backed up",
                     {.reason = "STORE_IN_MEMORY"});
  }
  if (is_under_way_.exchange(true)) {
    return Overloaded("another backup is under way", "BACKUP_UNDER_WAY");
  }
  holds_place_ = true;
  waits_ = true;
  runtime_.AddDrainable(weak_from_this());
  // The store may keep the function after it has called it; the call ends on its own.
  store->StartBackup(
      [weak = weak_from_this()](absl::StatusOr<std::shared_ptr<const Backup>> backup) {
        const auto call = weak.lock();
        if (call == nullptr || !call->waits_.exchange(false)) return;
        if (!backup.ok()) return call->End(backup.status());
        call->backup_ = *std::move(backup);
        call->Continue();
      });
  return absl::OkStatus();
}

void BackUpCall::Drain() {
  if (waits_.exchange(false)) End(Draining());
}

void BackUpCall::OnCancel() {
  stop_.request_stop();
  if (waits_.exchange(false)) End(CallCancelled());
}

void BackUpCall::Continue() {
  if (runtime_.robots.TryPush([self = shared_from_this()] { self->Step(); })) return;
  if (runtime_.draining()) return End(Draining());
  runtime_.timer.After(kPauseOfFullQueue, [self = shared_from_this()] { self->Continue(); });
}

void BackUpCall::Step() {
  const absl::Status status =
      RunGuarded([this](const CallContext&) { return WriteNext(); }, CallContext{});
  if (!status.ok()) End(status);
}

absl::Status BackUpCall::WriteNext() {
  if (runtime_.draining() && !is_last_) return Draining();
  if (stop_.stop_requested()) return CallCancelled();
  if (is_last_) {  // removing the copy takes a while, and the client may ask for the next one
    Release();
    End(absl::OkStatus());
    return absl::OkStatus();
  }
  const auto has_message = NextMessage();
  if (!has_message.ok()) return has_message.status();
  if (!*has_message) {
    Continue();
    return absl::OkStatus();
  }
  const grpc::Status serialized = SerializeResponse(message_, &written_);
  if (!serialized.ok()) return absl::InternalError(serialized.error_message());
  reading_ = StallTimers::Guard(runtime_.stalls, runtime_.application.limits.max_stall,
                                [this] { context_.TryCancel(); });
  StartWrite(&written_);
  return absl::OkStatus();
}

absl::StatusOr<bool> BackUpCall::NextMessage() {
  if (next_file_ == backup_->files().size()) {
    v1::BackUpEnd& end = *message_.mutable_end();
    end.set_file_count(static_cast<std::int64_t>(next_file_));
    end.set_bytes(total_);
    end.set_sequence(backup_->sequence());
    is_last_ = true;
    return true;
  }
  if (!in_.is_open() || hash_) return HashFile();
  std::string& data = *message_.mutable_data();
  data.resize(static_cast<std::size_t>(std::min(kMaxChunkBytes, size_ - sent_)));
  const auto count = ReadFile(data.data(), data.size());
  if (!count.ok()) return count.status();
  if (*count != data.size()) return ReadFailed(file());
  sent_ += static_cast<std::int64_t>(data.size());
  if (sent_ == size_) {
    in_.close();
    total_ += size_;
    ++next_file_;
  }
  return true;
}

absl::StatusOr<bool> BackUpCall::HashFile() {
  if (!in_.is_open()) {
    if (absl::Status opened = OpenFile(); !opened.ok()) return opened;
    hash_.emplace();
    size_ = 0;
  }
  std::string bytes(static_cast<std::size_t>(kMaxHashedInStep), '\0');
  const auto count = ReadFile(bytes.data(), bytes.size());
  if (!count.ok()) return count.status();
  hash_->Add(bytes.data(), *count);
  size_ += static_cast<std::int64_t>(*count);
  if (*count == bytes.size()) return false;
  v1::BackUpFile& announced = *message_.mutable_file();
  announced.set_path(file().path);
  announced.set_size_bytes(size_);
  announced.set_sha256(hash_->Hex());
  hash_.reset();
  sent_ = 0;
  in_.close();
  if (size_ > 0) return OpenFile().ok() ? absl::StatusOr<bool>(true) : ReadFailed(file());
  ++next_file_;
  return true;
}

absl::Status BackUpCall::OpenFile() {
  in_.clear();
  in_.open(file().source, std::ios::binary);
  return in_.is_open() ? absl::OkStatus() : ReadFailed(file());
}

// Fewer bytes than `size` are the end of the file.
absl::StatusOr<std::size_t> BackUpCall::ReadFile(char* bytes, std::size_t size) {
  in_.read(bytes, static_cast<std::streamsize>(size));
  if (in_.bad()) return ReadFailed(file());
  return static_cast<std::size_t>(in_.gcount());
}

void BackUpCall::OnWriteDone(bool ok) {
  reading_ = {};
  open_.NoteProgress();
  if (!ok) return End(CallCancelled());
  Continue();
}

// Keeps the turn for good: nothing else happens to this call.
void BackUpCall::End(const absl::Status& status) {
  Finish(ToGrpcStatus(DrainingIfStopped(status, runtime_)));
}

void BackUpCall::OnDone() {
  self_.reset();  // *this may be gone afterwards
}

}  // namespace cwm::server
