// Sends the newest frames of running sensors for display.
#pragma once

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include "cwm/v1/perception.grpc.pb.h"
#include "server/core/live/live_world.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

// Looks for newer frames at its rate, so that frames know nothing of who watches them. As in
// WatchCall, at most one holder has the turn: a look on the watch queue, or a message that is being
// written.
class WatchFramesCall final : public grpc::ServerWriteReactor<grpc::ByteBuffer>,
                              public std::enable_shared_from_this<WatchFramesCall> {
 public:
  static WatchFramesCall* Start(grpc::CallbackServerContext& context, Runtime& runtime,
                                const grpc::ByteBuffer* request);

 private:
  WatchFramesCall(Runtime& runtime, grpc::CallbackServerContext& context);

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  absl::Status CheckRequest();
  // Looks again after the period.
  void LookLater();
  void Look();
  // Fills message_; false if there is no newer frame.
  absl::StatusOr<bool> NextMessage();
  void End(const absl::Status& status);

  Runtime& runtime_;
  std::stop_source stop_;
  OpenCalls::Token open_{runtime_.open_calls, stop_};
  v1::WatchFramesRequest request_;
  Clock::duration period_ = {};
  std::int64_t max_points_ = 0;
  std::shared_ptr<WatchFramesCall> self_;  // until OnDone
  grpc::CallbackServerContext& context_;
  std::optional<QuotaShare> quota_share_;
  StallTimers::Guard reading_;  // while the client reads a message

  // Used only by the holder of the turn.
  std::shared_ptr<World> world_;
  std::uint64_t last_ = 0;  // number of the frame that was sent last
  Clock::time_point sent_ = {};
  grpc::ByteBuffer message_;  // being written

  std::mutex mutex_;
  bool turn_taken_ = true;  // taken by Start
  bool cancelled_ = false;
};

}  // namespace cwm::server
