#include "server/rpc/watch_call.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/rpc/call.h"
#include "server/rpc/status_conversion.h"
#include "server/wire/watch_events.h"

namespace cwm::server {
namespace {

// chosen: an idle watch sends its position this often.
constexpr auto kBookmarkPeriod = std::chrono::seconds(5);
// chosen: smaller messages fit into the buffers of a socket.
constexpr std::int64_t kMinChargedEventBytes = 64 << 10;

absl::StatusOr<WatchOptions> OptionsOf(const v1::WatchWorldRequest& request) {
  const FieldPath root;
  WatchOptions options;
  if (!v1::WatchMode_IsValid(request.mode())) {
    return root.Field("mode").Error(
        absl::StrCat("is ", static_cast<int>(request.mode()), ", must be a known WatchMode"));
  }
  if (request.mode() == v1::WATCH_MODE_COALESCED) options.mode = WatchMode::kCoalesced;
  if (!request.has_from_revision()) return options;
  if (request.from_revision() < 0) {
    return root.Field("from_revision").Error("is negative, must not be");
  }
  // At revision 0 every history is the same empty world; later ones can only be distinguished by
  // the uid.
  if (request.from_revision() > 0 && request.world_uid().empty()) {
    return root.Field("world_uid")
        .Error(absl::StrCat("is empty, must be that of the world whose revision ",
                            request.from_revision(), " is the from_revision"));
  }
  options.from_revision = collision::Revision{request.from_revision()};
  return options;
}

}  // namespace

WatchCall* WatchCall::Start(grpc::CallbackServerContext& context, Runtime& runtime,
                            const grpc::ByteBuffer* request) {
  const ClientId client = runtime.ClientOf(context);
  const bool is_viewers = client.connection == 0;
  FairQuota& quota = is_viewers ? runtime.viewer_watchers : runtime.watchers;
  const std::shared_ptr<WatchCall> call(new WatchCall(runtime, context));
  call->self_ = call;
  absl::Status parsed = runtime.application.gate.Check();
  if (parsed.ok()) parsed = ParseStreamRequest(request, &call->request_);
  if (!parsed.ok()) {
    call->End(parsed);
    return call.get();
  }
  call->quota_share_ = QuotaShare::TryTake(quota, client);
  if (call->quota_share_) {
    call->EnqueuePump();
  } else {
    call->End(
        Overloaded(absl::StrCat("there are ", quota.taken(),
                                is_viewers ? " watchers in browsers" : " watchers", " already, ",
                                quota.taken_by(HolderOf(client)), " of this client"),
                   is_viewers ? "TOO_MANY_VIEWERS" : "TOO_MANY_WATCHERS"));
  }
  return call.get();
}

WatchCall::WatchCall(Runtime& runtime, grpc::CallbackServerContext& context)
    : runtime_(runtime),
      context_(context),
      charge_(MemoryCharge::Empty(runtime.application.memory,
                                  MemoryBudget::Client(runtime.ClientOf(context)))) {}

void WatchCall::Wake() {
  {
    const std::lock_guard lock(mutex_);
    check_again_ = true;
    if (turn_taken_) return;
    turn_taken_ = true;
  }
  EnqueuePump();
}

void WatchCall::WakeWhenIdle() {
  runtime_.timer.After(kBookmarkPeriod, [weak = weak_from_this()] {
    const auto call = weak.lock();
    if (call == nullptr) return;
    {
      const std::lock_guard lock(call->mutex_);
      call->period_is_over_ = true;
    }
    call->Wake();
    call->WakeWhenIdle();
  });
}

// Must be called only by the holder of the turn.
void WatchCall::EnqueuePump() {
  if (runtime_.watch.TryPush([self = shared_from_this()] { self->Pump(); })) return;
  End(Draining());
}

void WatchCall::Pump() {
  const CallWork work = [this](const CallContext&) {
    for (;;) {
      auto has_message = NextMessage();
      if (!has_message.ok()) return has_message.status();
      if (*has_message) {
        reading_ = StallTimers::Guard(runtime_.stalls, runtime_.application.limits.max_stall,
                                      [this] { context_.TryCancel(); });
        StartWrite(&message_);
        return absl::OkStatus();
      }
      if (ReturnTurn()) return absl::OkStatus();
    }
  };
  const absl::Status status = RunGuarded(work, {});
  if (!status.ok()) End(status);
}

absl::Status WatchCall::Open() {
  const FieldPath root;
  auto view = ViewFromProto(request_.view(), View::kShapes, root.Field("view"));
  if (!view.ok()) return view.status();
  view_ = *view;
  auto options = OptionsOf(request_);
  if (!options.ok()) return options.status();
  auto world = runtime_.application.worlds.Find(request_.world(), request_.world_uid());
  if (!world.ok()) return world.status();
  world_ = *std::move(world);
  // The initial state includes earlier observations; a resumed watch is sent those of every object.
  if (!request_.has_from_revision()) observed_ = world_->observations().last_number();
  auto cursor = world_->Watch(*options, [weak = weak_from_this()] {
    if (const auto call = weak.lock()) call->Wake();
  });
  if (!cursor.ok()) return cursor.status();
  cursor_ = *std::move(cursor);
  WakeWhenIdle();
  return absl::OkStatus();
}

absl::StatusOr<bool> WatchCall::NextMessage() {
  {
    const std::lock_guard lock(mutex_);
    check_again_ = false;
    if (std::exchange(period_is_over_, false)) bookmark_is_due_ = true;
    if (cancelled_) return CallCancelled();
  }
  if (cursor_ == nullptr) {
    if (auto status = Open(); !status.ok()) return status;
  }
  if (initial_ == nullptr && !step_.has_value()) {
    auto has_step = NextStep();
    if (!has_step.ok() || !*has_step) return has_step;
  }
  const grpc::Status serialized = SerializeResponse(NextPiece(), &message_);
  if (!serialized.ok()) return absl::InternalError(serialized.error_message());
  // Charged until the client has read it.
  const auto size = static_cast<std::int64_t>(message_.Length());
  const absl::Status charged = charge_.Resize(size < kMinChargedEventBytes ? 0 : size);
  if (!charged.ok()) return charged;
  return true;
}

// Sets the next data to send; false if there is none now.
absl::StatusOr<bool> WatchCall::NextStep() {
  // Observations are sent once per period, however many events there are.
  if (bookmark_is_due_ && has_sent_) return NextBookmark();
  auto step = cursor_->Next();
  if (!step.ok()) return step.status();
  if (!step->has_value()) return bookmark_is_due_ && NextBookmark();
  has_sent_ = true;
  last_ = (*step)->last;
  next_ = 0;
  if ((*step)->kind == WatchStep::Kind::kInitialState) {
    initial_ = (*step)->snapshot;
  } else {
    step_ = **std::move(step);
  }
  return true;
}

bool WatchCall::NextBookmark() {
  bookmark_is_due_ = false;
  step_ = WatchStep{.kind = WatchStep::Kind::kBookmark, .revision = cursor_->position()};
  return true;
}

v1::WatchWorldResponse WatchCall::NextPiece() {
  const WatchContext context{*world_, view_, runtime_.application.geometry};
  v1::WatchWorldResponse message;
  if (initial_ != nullptr) {
    message = InitialStatePiece(*initial_, context, &next_);
    if (message.initial_state().initial_state_done()) initial_ = nullptr;
  } else if (step_->kind == WatchStep::Kind::kEvents) {
    message = EventsPiece(*step_, context, &next_);
    if (!message.events().more()) step_.reset();
  } else {
    message = BookmarkMessage(step_->revision, *world_, &observed_);
    step_.reset();
  }
  return message;
}

// False if something happened meanwhile, so that the holder must check again.
bool WatchCall::ReturnTurn() {
  const std::lock_guard lock(mutex_);
  if (check_again_ || cancelled_) return false;
  turn_taken_ = false;
  return true;
}

void WatchCall::OnWriteDone(bool ok) {
  reading_ = {};
  open_.NoteProgress();
  if (!ok) return End(CallCancelled());
  if (last_ && initial_ == nullptr && !step_.has_value()) return End(Draining());
  EnqueuePump();
}

void WatchCall::OnCancel() {
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
    if (turn_taken_) return;  // the holder of the turn notices
    turn_taken_ = true;
  }
  End(CallCancelled());
}

// Keeps the turn for good: nothing else happens to this call.
void WatchCall::End(const absl::Status& status) {
  // A deleted world may be freed with its last watch: here, not on gRPC's thread that runs OnDone.
  step_.reset();
  initial_.reset();
  cursor_.reset();
  world_.reset();
  Finish(ToGrpcStatus(status));
}

void WatchCall::OnDone() {
  self_.reset();  // *this may be gone afterwards
}

}  // namespace cwm::server
