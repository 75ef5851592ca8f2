// A read that is answered in chunks of bytes.
#pragma once

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "proto/transfer/chunks.h"
#include "server/core/error.h"
#include "server/rpc/call.h"
#include "server/rpc/messages.h"
#include "server/rpc/status_conversion.h"

namespace cwm::server {

// chosen: a local client that reads at all takes less than this for a chunk.
inline constexpr std::chrono::milliseconds kMaxHeldUnread{1'000};

// Waits for its revision, is prepared on a queue, then written as fast as the client reads, without
// keeping a world alive. Bytes that a client leaves unread for kMaxHeldUnread are freed if they can
// be made again. Deletes itself when gRPC is done with it.
template <class Response>
class ChunkedRead : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 protected:
  ChunkedRead(grpc::CallbackServerContext* context, Runtime& runtime, WorkQueue& queue)
      : runtime_(runtime),
        queue_(queue),
        context_(context),
        call_{.deadline = DeadlineOf(*context),
              .stop = stop_.get_token(),
              .client = runtime.ClientOf(*context)} {}

  // Checks that calls are served, then parses. Must come before anything is looked up in the
  // application, which may have no worlds before.
  template <class Request>
  absl::Status ReadRequest(const grpc::ByteBuffer* bytes, Request* request) const {
    const absl::Status serving = runtime_.CheckServing();
    return serving.ok() ? ParseStreamRequest(bytes, request) : serving;
  }

  // Must be the last statement of a constructor.
  void Start(const absl::StatusOr<std::optional<RevisionToAwait>>& await) {
    if (!await.ok()) return this->Finish(ToGrpcStatus(await.status()));
    if (!await->has_value()) return Enqueue();
    const std::shared_ptr<World>& world = (*await)->world;
    runtime_.waits.Await({.world = world,
                          .revision = (*await)->revision,
                          .deadline = call_.deadline,
                          .stop = call_.stop,
                          .client = call_.client},
                         queue_, [this, world](absl::StatusOr<SnapshotPtr> snapshot) {
                           if (!snapshot.ok()) {
                             return this->Finish(ToGrpcStatus(snapshot.status()));
                           }
                           call_.reached = {world, *std::move(snapshot)};
                           Open();
                         });
  }

  // Sets the bytes, the offset to begin at, and the rest of the first message. Called again after
  // ReleaseBytes; the offset must then stay as it is.
  virtual absl::Status Prepare(const CallContext& call) = 0;
  // Frees the bytes if Prepare can make the same ones again.
  virtual void ReleaseBytes() {}
  // Sets the fields of a message other than offset, data and done.
  virtual void Complete(Response& message) = 0;
  void OnDone() override { delete this; }

  Runtime& runtime_;
  WorkQueue& queue_;  // the queue that prepares it
  std::shared_ptr<const std::string> bytes_;
  std::size_t offset_ = 0;  // of the next chunk
  Response message_;

 private:
  void Enqueue() {
    queue_.Push({.run =
                     [this](const absl::Status& admitted) {
                       if (!admitted.ok()) return this->Finish(ToGrpcStatus(admitted));
                       Open();
                     },
                 .client = call_.client,
                 .deadline = call_.deadline});
  }

  void Open() {
    const absl::Status status =
        runtime_.draining()
            ? Draining()
            : RunGuarded([this](const CallContext& call) { return Prepare(call); }, call_);
    call_.reached.reset();  // so that a slow reader keeps no world alive
    if (!status.ok()) return this->Finish(ToGrpcStatus(DrainingIfStopped(status, runtime_)));
    // A chunk is in memory twice, in the message and in the socket.
    charge_ = MemoryCharge::Empty(runtime_.application.memory, MemoryBudget::Client(call_.client));
    const absl::Status charged = charge_.Resize(static_cast<std::int64_t>(
        2 * std::min<std::size_t>(kMaxChunkBytes, bytes_->size() - offset_)));
    if (!charged.ok()) return this->Finish(ToGrpcStatus(charged));
    WriteNext();
  }

  void WriteNext() {
    const absl::Status made = RunGuarded(
        [this](const CallContext&) {
          MakeNext();
          const grpc::Status serialized = SerializeResponse(message_, &written_);
          std::string().swap(*message_.mutable_data());  // frees it: `written_` has a copy
          return serialized.ok() ? absl::OkStatus()
                                 : absl::InternalError(serialized.error_message());
        },
        call_);
    if (!made.ok()) return this->Finish(ToGrpcStatus(made));
    holding_ = StallTimers::Guard(runtime_.stalls, kMaxHeldUnread, [this] { ReleaseBytes(); });
    reading_ = StallTimers::Guard(runtime_.stalls, runtime_.application.limits.max_stall,
                                  [context = context_] { context->TryCancel(); });
    this->StartWrite(&written_);
  }

  void MakeNext() {
    message_.set_offset(static_cast<std::int64_t>(offset_));
    const std::size_t count = std::min<std::size_t>(kMaxChunkBytes, bytes_->size() - offset_);
    message_.set_data(bytes_->data() + offset_, count);
    offset_ += count;
    message_.set_done(offset_ == bytes_->size());
    Complete(message_);
  }

  void OnWriteDone(bool ok) override {
    holding_ = {};
    reading_ = {};
    open_.NoteProgress();
    if (message_.done() && ok) return this->Finish(grpc::Status::OK);
    if (!ok || call_.stop.stop_requested()) {
      return this->Finish(ToGrpcStatus(DrainingIfStopped(CallCancelled(), runtime_)));
    }
    if (bytes_ == nullptr) return Enqueue();
    WriteNext();
  }
  void OnCancel() override { stop_.request_stop(); }

  grpc::CallbackServerContext* const context_;
  std::stop_source stop_;
  OpenCalls::Token open_{runtime_.open_calls, stop_};

 protected:
  CallContext call_;

 private:
  grpc::ByteBuffer written_;    // the message being written
  MemoryCharge charge_;         // for a chunk
  StallTimers::Guard holding_;  // limits how long bytes are held while a message is being written
  StallTimers::Guard reading_;  // limits how long the client takes to read a message
};

}  // namespace cwm::server
