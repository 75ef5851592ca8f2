#include "server/rpc/watch_frames_call.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/core/world_feed.h"
#include "server/rpc/call.h"
#include "server/rpc/status_conversion.h"
#include "server/wire/numbers.h"
#include "server/wire/sensors.h"

namespace cwm::server {
namespace {

// chosen: enough for a picture, 260 kB a frame.
constexpr std::int64_t kUsualPoints = 20'000;
// derived: 13 bytes a point stay below the 4 MiB that gRPC clients receive by default.
constexpr std::int64_t kMaxPoints = 300'000;
constexpr double kUsualRate_Hz = 10;
constexpr double kMaxRate_Hz = 60;

}  // namespace

WatchFramesCall* WatchFramesCall::Start(grpc::CallbackServerContext& context, Runtime& runtime,
                                        const grpc::ByteBuffer* request) {
  const ClientId client = runtime.ClientOf(context);
  const bool is_viewers = client.connection == 0;
  const std::shared_ptr<WatchFramesCall> call(new WatchFramesCall(runtime, context));
  call->self_ = call;
  absl::Status ready = runtime.CheckServing();
  if (ready.ok()) ready = ParseStreamRequest(request, &call->request_);
  if (ready.ok()) ready = call->CheckRequest();
  if (ready.ok()) {
    FairQuota& quota = is_viewers ? runtime.viewer_watchers : runtime.watchers;
    call->quota_share_ = QuotaShare::TryTake(quota, client);
    if (!call->quota_share_) {
      ready = Overloaded("too many watchers are open",
                         is_viewers ? "TOO_MANY_VIEWERS" : "TOO_MANY_WATCHERS");
    }
  }
  if (ready.ok()) {
    if (!runtime.watch.TryPush([call] { call->Look(); })) call->End(Draining());
  } else {
    call->End(ready);
  }
  return call.get();
}

WatchFramesCall::WatchFramesCall(Runtime& runtime, grpc::CallbackServerContext& context)
    : runtime_(runtime), context_(context) {}

absl::Status WatchFramesCall::CheckRequest() {
  const FieldPath root;
  const FieldPath points_path = root.Field("max_points");
  if (auto status = CheckRange(request_.max_points(), {0, kMaxPoints}, points_path); !status.ok()) {
    return status;
  }
  max_points_ = request_.max_points() == 0 ? kUsualPoints : request_.max_points();
  const double rate_Hz = request_.max_rate_hz() == 0 ? kUsualRate_Hz : request_.max_rate_hz();
  if (!(rate_Hz > 0 && rate_Hz <= kMaxRate_Hz)) {
    return root.Field("max_rate_hz")
        .Error(absl::StrCat("is ", request_.max_rate_hz(), ", must be from 0 to ", kMaxRate_Hz));
  }
  period_ = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / rate_Hz));
  return absl::OkStatus();
}

void WatchFramesCall::Look() {
  const CallWork work = [this](const CallContext&) {
    auto has_message = NextMessage();
    if (!has_message.ok()) return has_message.status();
    if (!*has_message) {
      LookLater();
      return absl::OkStatus();
    }
    sent_ = Clock::now();
    reading_ = StallTimers::Guard(runtime_.stalls, runtime_.application.limits.max_stall,
                                  [this] { context_.TryCancel(); });
    StartWrite(&message_);
    return absl::OkStatus();
  };
  const absl::Status status = RunGuarded(work, {});
  if (!status.ok()) End(status);
}

absl::StatusOr<bool> WatchFramesCall::NextMessage() {
  {
    const std::lock_guard lock(mutex_);
    if (cancelled_ || stop_.stop_requested()) return CallCancelled();
  }
  if (runtime_.draining()) return Draining();
  WorldRegistry& worlds = runtime_.application.worlds;
  if (world_ == nullptr) {
    auto world = worlds.Find(request_.world(), request_.world_uid());
    if (!world.ok()) return world.status();
    world_ = *std::move(world);
  } else if (!worlds.Find(request_.world(), world_->uid()).ok()) {
    return WorldDeleted();
  }
  const auto live = runtime_.live_worlds.Find(world_->uid());
  if (live == nullptr) return false;
  const auto frames = live->FramesAfter(last_, request_.sensor());
  if (frames.empty()) return false;
  const DisplayFrame& frame = *frames.front();  // of several sensors the one that waited longest
  last_ = frame.number;
  v1::WatchFramesResponse message = DisplayFrameToProto(frame, max_points_);
  message.set_world_uid(world_->uid());
  const grpc::Status serialized = SerializeResponse(message, &message_);
  if (!serialized.ok()) return absl::InternalError(serialized.error_message());
  return true;
}

void WatchFramesCall::LookLater() {
  const auto self = shared_from_this();  // without the turn the call may end at any time
  bool is_cancelled = false;
  {
    const std::lock_guard lock(mutex_);
    is_cancelled = cancelled_;
    turn_taken_ = is_cancelled;
  }
  if (is_cancelled) return End(CallCancelled());
  const Clock::duration since = Clock::now() - sent_;
  const Clock::duration left = since < period_ ? period_ - since : period_;
  runtime_.timer.After(left, [weak = weak_from_this()] {
    const auto call = weak.lock();
    if (call == nullptr) return;
    {
      const std::lock_guard lock(call->mutex_);
      if (std::exchange(call->turn_taken_, true)) return;
    }
    if (!call->runtime_.watch.TryPush([call] { call->Look(); })) call->End(Draining());
  });
}

void WatchFramesCall::OnWriteDone(bool ok) {
  reading_ = {};
  open_.NoteProgress();
  if (!ok) return End(CallCancelled());
  message_.Clear();
  LookLater();
}

void WatchFramesCall::OnCancel() {
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
    if (std::exchange(turn_taken_, true)) return;  // the holder of the turn notices
  }
  End(CallCancelled());
}

// Keeps the turn for good: nothing else happens to this call.
void WatchFramesCall::End(const absl::Status& status) {
  world_.reset();
  Finish(ToGrpcStatus(DrainingIfStopped(status, runtime_)));
}

void WatchFramesCall::OnDone() {
  self_.reset();  // *this may be gone afterwards
}

}  // namespace cwm::server
