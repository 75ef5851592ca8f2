// Sends a copy of the store, file by file.
#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <memory>
#include <optional>
#include <stop_token>

#include "cwm/v1/admin.grpc.pb.h"
#include "proto/transfer/sha256.h"
#include "server/rpc/call.h"

namespace cwm::server {

// Waits until the store has made its copy, then reads it on a queue, as fast as the client takes
// it. Each file is read twice, since its SHA-256 is sent first. Owns itself until gRPC is done with
// it. A server that drains ends it.
class BackUpCall final : public grpc::ServerWriteReactor<grpc::ByteBuffer>,
                         public Drainable,
                         public std::enable_shared_from_this<BackUpCall> {
 public:
  // At most one call at a time sets `is_under_way`, since each copy takes as much room on the disk
  // as the store. `is_under_way` must outlive the call.
  static BackUpCall* Start(grpc::CallbackServerContext& context, Runtime& runtime,
                           const grpc::ByteBuffer* request, std::atomic<bool>& is_under_way);
  ~BackUpCall() override;

  void Drain() override;

 private:
  BackUpCall(Runtime& runtime, grpc::CallbackServerContext& context,
             std::atomic<bool>& is_under_way);

  // Frees the copy's room, then lets the next call begin.
  void Release();
  absl::Status Begin(const grpc::ByteBuffer* request);
  // Enqueues the next step. Only the holder of the turn calls it: the end of the wait for the copy,
  // of a step or of a write.
  void Continue();
  void Step();
  absl::Status WriteNext();
  // Sets the next message; false while more of the file must be hashed first.
  absl::StatusOr<bool> NextMessage();
  absl::StatusOr<bool> HashFile();
  absl::Status OpenFile();
  absl::StatusOr<std::size_t> ReadFile(char* bytes, std::size_t size);
  void End(const absl::Status& status);

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  const BackupFile& file() const { return backup_->files()[next_file_]; }

  Runtime& runtime_;
  grpc::CallbackServerContext& context_;
  std::atomic<bool>& is_under_way_;
  bool holds_place_ = false;  // this call has set is_under_way_
  std::stop_source stop_;
  OpenCalls::Token open_{runtime_.open_calls, stop_};
  std::shared_ptr<BackUpCall> self_;  // until OnDone
  std::atomic<bool> waits_ = false;   // for the copy; who resets it has the turn

  std::shared_ptr<const Backup> backup_;
  std::size_t next_file_ = 0;  // the file being sent
  std::ifstream in_;
  std::optional<Sha256> hash_;  // while the file is being hashed
  std::int64_t size_ = 0;       // bytes of the file that are hashed
  std::int64_t sent_ = 0;       // bytes of the file that are sent
  std::int64_t total_ = 0;      // bytes of all files before it
  bool is_last_ = false;        // all is written or being written
  v1::BackUpResponse message_;
  grpc::ByteBuffer written_;
  StallTimers::Guard reading_;  // limits how long the client takes to read a message
};

}  // namespace cwm::server
