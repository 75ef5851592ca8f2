// A watch of a world: its cursor is read on the watch queue whenever it may have something new.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <mutex>
#include <optional>

#include "cwm/v1/world.grpc.pb.h"
#include "server/rpc/runtime.h"
#include "server/wire/objects.h"

namespace cwm::server {

// At any time at most one holder has the turn: a task on the watch queue, or a message being
// written. Only the holder uses the cursor, writes or finishes.
class WatchCall final : public grpc::ServerWriteReactor<grpc::ByteBuffer>,
                        public std::enable_shared_from_this<WatchCall> {
 public:
  static WatchCall* Start(grpc::CallbackServerContext& context, Runtime& runtime,
                          const grpc::ByteBuffer* request);

 private:
  WatchCall(Runtime& runtime, grpc::CallbackServerContext& context);

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  // Takes the turn if it is free; otherwise makes its holder check again.
  void Wake();
  void WakeWhenIdle();
  void EnqueuePump();
  void Pump();
  absl::Status Open();
  // Fills message_; false if there is nothing to send now.
  absl::StatusOr<bool> NextMessage();
  absl::StatusOr<bool> NextStep();
  bool NextBookmark();  // always true
  v1::WatchWorldResponse NextPiece();
  bool ReturnTurn();
  void End(const absl::Status& status);

  Runtime& runtime_;
  OpenCalls::Token open_{runtime_.open_calls};
  v1::WatchWorldRequest request_;
  std::shared_ptr<WatchCall> self_;  // until OnDone
  grpc::CallbackServerContext& context_;
  MemoryCharge charge_;  // for message_
  std::optional<QuotaShare> quota_share_;
  StallTimers::Guard reading_;  // while the client reads a message

  // Used only by the holder of the turn.
  View view_ = View::kShapes;
  std::shared_ptr<World> world_;
  std::unique_ptr<WatchCursor> cursor_;
  SnapshotPtr initial_;            // being sent
  std::optional<WatchStep> step_;  // events being sent
  std::size_t next_ = 0;           // object of initial_, or delta of step_
  std::uint64_t observed_ = 0;     // number of the last observation that was sent
  bool last_ = false;              // message_ is the last message
  grpc::ByteBuffer message_;       // being written
  bool has_sent_ = false;          // the initial state or an event was sent
  bool bookmark_is_due_ = false;

  std::mutex mutex_;
  bool turn_taken_ = true;  // taken by Start
  bool check_again_ = false;
  bool cancelled_ = false;
  bool period_is_over_ = false;  // the period of bookmarks
};

}  // namespace cwm::server
