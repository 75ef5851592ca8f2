#include "server/rpc/stream_clouds_call.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/core/live/robot_states.h"
#include "server/core/world_feed.h"
#include "server/rpc/call.h"
#include "server/rpc/messages.h"
#include "server/rpc/status_conversion.h"
#include "server/wire/times.h"

namespace cwm::server {
namespace {

constexpr char kStreamClouds[] = "/cwm.v1.PerceptionService/StreamClouds";

// chosen: a client that does not read its answers is not read from either; each has a few hundred
// bytes.
constexpr std::size_t kMaxUnreadAnswers = 1'024;
// derived: about twenty images of single precision in the view and in what is shown of it.
constexpr std::int64_t kViewBytesPerPixel = 80;
// measured: a view has 0.6 MiB of tables beside its pixels, and 0.8 MiB with a range of 80 m.
constexpr std::int64_t kViewBytes = 1 << 20;
// measured: a frame takes about so long on one core, which shares the queue among clients.
constexpr double kFrame_s = 0.005;
constexpr double kScan_s = 0.5;
// chosen: a frame waits for so long for states of robots. States at 30 Hz then tell each stamp, with
// those 20 ms for which they are extrapolated.
constexpr std::chrono::milliseconds kMaxWaitForStates{20};
constexpr std::chrono::milliseconds kStatesPoll{1};

}  // namespace

StreamCloudsCall* StreamCloudsCall::Start(grpc::CallbackServerContext* context, Runtime& runtime) {
  const std::shared_ptr<StreamCloudsCall> call(new StreamCloudsCall(context, runtime));
  call->self_ = call;
  if (absl::Status serving = runtime.CheckServing(); !serving.ok()) {
    call->Fail(serving);
    return call.get();
  }
  call->quota_share_ = QuotaShare::TryTake(runtime.streams, call->client_);
  if (call->quota_share_) {
    call->Advance();
    runtime.AddDrainable(call);
  } else {
    call->Fail(Overloaded("too many streams are open", "TOO_MANY_STREAMS"));
  }
  return call.get();
}

StreamCloudsCall::StreamCloudsCall(grpc::CallbackServerContext* context, Runtime& runtime)
    : runtime_(runtime), context_(context), client_(runtime.ClientOf(*context)) {}

void StreamCloudsCall::Advance() {
  const auto self = shared_from_this();  // advancing may end the call
  const std::lock_guard lock(mutex_);
  if (!is_over_) AdvanceLocked();
}

void StreamCloudsCall::AdvanceLocked() {
  const auto answer = answers_.find(next_answer_);
  if (answer != answers_.end() && !is_writing_ && !client_is_gone_) {
    SerializeResponse(answer->second, &written_);
    answers_.erase(answer);
    ++next_answer_;
    is_writing_ = true;
    reading_ = StallTimers::Guard(runtime_.stalls, runtime_.application.limits.max_stall,
                                  [this] { context_->TryCancel(); });
    StartWrite(&written_);
  }
  if (!is_reading_ && !client_is_done_ && !IsOver() && answers_.size() < kMaxUnreadAnswers) {
    is_reading_ = true;
    StartRead(&read_);
  }
  FinishIfOver();
}

bool StreamCloudsCall::IsOver() const {
  return client_is_gone_ || !error_.ok() || stop_.stop_requested() || runtime_.draining();
}

void StreamCloudsCall::FinishIfOver() {
  if (is_processing_ || is_writing_) return;
  const bool is_cancelled = client_is_gone_ || stop_.stop_requested();
  if (!is_cancelled && answers_.contains(next_answer_)) return;  // it is written first
  absl::Status status = error_;
  if (is_cancelled) {
    status = CallCancelled();
  } else if (error_.ok() && runtime_.draining()) {
    status = Draining();
  } else if (error_.ok()) {
    if (!client_is_done_ || is_reading_ || waiting_.has_value()) return;
    if (!plan_.has_value()) status = InvalidField("calibration", "is absent, must come first");
  }
  is_over_ = true;
  status = DrainingIfStopped(status, runtime_);
  if (!status.ok()) {
    runtime_.log.Refused(kStreamClouds, status.code(), DetailsOf(status).reason, client_);
  }
  Finish(ToGrpcStatus(status));
}

void StreamCloudsCall::OnReadDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    received_ = Clock::now();
    if (!ok) {
      client_is_done_ = true;
      is_reading_ = false;
    }
    ok = ok && !is_over_;
  }
  if (!ok) return Advance();
  Enqueue(&StreamCloudsCall::TakeMessage);
}

void StreamCloudsCall::OnWriteDone(bool ok) {
  reading_ = {};
  open_.NoteProgress();
  {
    const std::lock_guard lock(mutex_);
    is_writing_ = false;
    client_is_gone_ = !ok;
    written_.Clear();
  }
  Advance();
}

void StreamCloudsCall::OnCancel() {
  stop_.request_stop();
  Advance();
}

void StreamCloudsCall::Enqueue(void (StreamCloudsCall::*work)()) {
  runtime_.live.Push({.run =
                          [self = shared_from_this(), work](const absl::Status& admitted) {
                            if (!admitted.ok()) self->Fail(admitted);
                            (self.get()->*work)();
                          },
                      .client = client_,
                      .cost_s = kFrame_s});
}

bool StreamCloudsCall::WaitsAsScan() {
  bool has_pose = true;
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.has_value()) has_pose = waiting_->message.has_x_world_sensor();
  }
  return !has_pose && sensor_->MustIngestFirst(has_pose);
}

void StreamCloudsCall::EnqueueScan() {
  runtime_.ingest.Push(
      {.run = [self = shared_from_this()](
                  const absl::Status& admitted) { self->ProcessOrRefuse(admitted); },
       .client = client_,
       .cost_s = kScan_s});
}

void StreamCloudsCall::EnqueueTurn() {
  sensor_->BeginTurn([self = shared_from_this()] {
    {
      const std::lock_guard lock(self->mutex_);
      if (self->IsOver()) self->waiting_.reset();
    }
    self->WaitsAsScan() ? self->EnqueueScan() : self->Enqueue(&StreamCloudsCall::ProcessWaiting);
  });
}

void StreamCloudsCall::ProcessNext(bool here) {
  if (WaitsAsScan()) return EnqueueScan();
  if (AwaitsStates()) return AwaitStates(Clock::now() + kMaxWaitForStates);
  here ? ProcessWaiting() : Enqueue(&StreamCloudsCall::ProcessWaiting);
}

bool StreamCloudsCall::AwaitsStates() {
  const std::lock_guard lock(mutex_);
  if (IsOver() || !waiting_.has_value() || !waiting_->message.has_frame_stamp()) return false;
  const auto stamp =
      TimePointFromProto(waiting_->message.frame_stamp(), FieldPath::OfRequest("frame"));
  return stamp.ok() && world_->robot_states().Awaits(*stamp);
}

// A newer frame that takes the place of the one that waits has the rest of its time.
void StreamCloudsCall::AwaitStates(Clock::time_point until) {
  runtime_.timer.After(kStatesPoll, [self = shared_from_this(), until] {
    if (Clock::now() < until && self->AwaitsStates()) return self->AwaitStates(until);
    self->Enqueue(&StreamCloudsCall::ProcessWaiting);
  });
}

void StreamCloudsCall::Fail(const absl::Status& status) {
  const auto self = shared_from_this();
  const std::lock_guard lock(mutex_);
  if (error_.ok()) error_ = status;
  if (!is_over_) AdvanceLocked();
}

void StreamCloudsCall::TakeMessage() {
  const absl::Status taken = RunGuarded([this](const CallContext&) { return Take(); }, {});
  bool begins = false;
  {
    const std::lock_guard lock(mutex_);
    if (!taken.ok() && error_.ok()) error_ = taken;
    is_reading_ = false;
    read_.Clear();
    begins = waiting_.has_value() && !is_processing_ && !IsOver();
    if (begins) is_processing_ = true;
  }
  Advance();  // the next message is read while this one is processed
  if (!begins) return;
  if (plan_->calibration.in_lockstep) return EnqueueTurn();
  ProcessNext(/*here=*/true);
}

absl::Status StreamCloudsCall::Take() {
  {
    const std::lock_guard lock(mutex_);
    if (IsOver()) return absl::OkStatus();
  }
  // While it is parsed, the message is in memory twice.
  MemoryCharge charge =
      MemoryCharge::Empty(runtime_.application.memory, MemoryBudget::Client(client_));
  const auto size = static_cast<std::int64_t>(read_.Length());
  if (absl::Status charged = charge.Resize(2 * size); !charged.ok()) {
    if (!plan_.has_value()) return charged;
    RefuseUnread(charged);
    return absl::OkStatus();
  }
  v1::StreamCloudsRequest message;
  WorkBudget budget(Clock::time_point::max(), stop_.get_token());
  if (absl::Status parsed = ParseRequest(read_, &message, &budget); !parsed.ok()) return parsed;
  charge.ForceResize(static_cast<std::int64_t>(message.SpaceUsedLong()));
  switch (message.what_case()) {
    case v1::StreamCloudsRequest::kCalibration:
      return TakeCalibration(message.calibration());
    case v1::StreamCloudsRequest::kFrame:
      return TakeFrame(*message.mutable_frame(), std::move(charge));
    case v1::StreamCloudsRequest::WHAT_NOT_SET:
      break;
  }
  return InvalidField("what", "is absent, must be one of calibration, frame");
}

absl::Status StreamCloudsCall::TakeCalibration(const v1::SensorCalibration& calibration) {
  if (plan_.has_value()) return InvalidField("calibration", "came twice, must come once");
  auto plan = SensorPlanFromProto(calibration, runtime_.application.limits,
                                  FieldPath::OfRequest("calibration"));
  if (!plan.ok()) return plan.status();
  MemoryCharge view =
      MemoryCharge::Empty(runtime_.application.memory, MemoryBudget::Client(client_));
  if (auto charged = view.Resize(kViewBytes + kViewBytesPerPixel * plan->pixel_count());
      !charged.ok()) {
    return charged;
  }
  WorldRegistry& worlds = runtime_.application.worlds;
  auto world = plan->world_uid.empty() ? worlds.FindOrCreate(plan->world)
                                       : worlds.Find(plan->world, plan->world_uid);
  if (!world.ok()) return world.status();
  const std::shared_ptr<LiveWorld> live = runtime_.live_worlds.Of(*world);
  auto sensor = live->Open(plan->calibration, [weak = weak_from_this()](const absl::Status& why) {
    if (const auto call = weak.lock()) call->Fail(why);
  });
  if (!sensor.ok()) return sensor.status();
  (*sensor)->Hold(std::move(view));
  // It may have been deleted just before the stream began, and then nobody tells.
  if (!worlds.Find(plan->world, (*world)->uid()).ok()) runtime_.live_worlds.Forget(**world);
  world_ = *std::move(world);
  sensor_ = *std::move(sensor);
  plan_ = *std::move(plan);
  runtime_.WatchSensors();
  return absl::OkStatus();
}

absl::Status StreamCloudsCall::TakeFrame(v1::SensorFrame& message, MemoryCharge charge) {
  if (!plan_.has_value()) return InvalidField("frame", "came before the calibration");
  std::optional<Frame> dropped;
  {
    const std::lock_guard lock(mutex_);
    dropped = std::exchange(waiting_, std::nullopt);
    waiting_.emplace(Frame{.number = frame_count_++,
                           .message = std::move(message),
                           .charge = std::move(charge),
                           .received = received_});
  }
  if (dropped.has_value()) {
    sensor_->NoteDropped();
    Answer(dropped->number, ResponseTo(*dropped, {.fate = FrameFate::kDropped,
                                                  .revision = world_->Snapshot()->revision()}));
  }
  return absl::OkStatus();
}

void StreamCloudsCall::ProcessOrRefuse(const absl::Status& admitted) {
  std::optional<Frame> frame;
  {
    const std::lock_guard lock(mutex_);
    frame = std::exchange(waiting_, std::nullopt);
  }
  absl::Status ended;
  std::optional<NumberedAnswer> answer;
  if (frame.has_value()) {
    FrameOutcome outcome;
    ended = RunGuarded(
        [&](const CallContext&) {
          auto processed = admitted.ok() ? Process(*frame) : RefusedOutcome(admitted);
          if (!processed.ok()) return processed.status();
          outcome = *std::move(processed);
          return absl::OkStatus();
        },
        {});
    if (plan_->calibration.in_lockstep) outcome.interpreting = false;  // answered afterwards
    if (ended.ok()) answer = NumberedAnswer{frame->number, ResponseTo(*frame, outcome)};
    frame.reset();
  }
  if (!plan_->calibration.in_lockstep) return FinishFrame(ended, std::move(answer));
  sensor_->EndTurn([self = shared_from_this(), ended, answer = std::move(answer)] {
    self->FinishFrame(ended, answer);
  });
}

void StreamCloudsCall::FinishFrame(const absl::Status& ended,
                                   std::optional<NumberedAnswer> answer) {
  if (answer.has_value()) Answer(answer->number, std::move(answer->response));
  bool goes_on = false;
  {
    const std::lock_guard lock(mutex_);
    if (!ended.ok() && error_.ok()) error_ = ended;
    goes_on = waiting_.has_value() && !IsOver();
    is_processing_ = goes_on;
  }
  Advance();
  // Other sensors take their turns in between.
  if (!goes_on) return;
  if (plan_->calibration.in_lockstep) return EnqueueTurn();
  ProcessNext(/*here=*/false);
}

void StreamCloudsCall::RefuseUnread(const absl::Status& why) {
  std::int64_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    number = frame_count_++;
  }
  Frame unread;
  unread.number = number;
  Answer(number, ResponseTo(unread, RefusedOutcome(why)));
}

absl::StatusOr<FrameOutcome> StreamCloudsCall::Process(const Frame& frame) {
  const FieldPath path = FieldPath::OfRequest("frame");
  const Clock::time_point begun = Clock::now();
  auto live = FrameFromProto(frame.message, std::chrono::system_clock::now(), path);
  if (!live.ok()) return RefusedOutcome(live.status());
  std::optional<perception::DepthCamera> known;
  if (plan_->points.has_value()) known = sensor_->camera();
  if (auto status = ImageFromProto(frame.message, *plan_, known, path, *live); !status.ok()) {
    return RefusedOutcome(status);
  }
  live->received = frame.received;
  live->begun = begun;
  live->decoded = Clock::now();
  return sensor_->Process(*live);
}

FrameOutcome StreamCloudsCall::RefusedOutcome(const absl::Status& why) const {
  sensor_->NoteRefused();
  return {.fate = FrameFate::kRefused,
          .reason = DetailsOf(why).reason,
          .message = std::string(why.message()),
          .revision = world_->Snapshot()->revision()};
}

v1::StreamCloudsResponse StreamCloudsCall::ResponseTo(const Frame& frame,
                                                      const FrameOutcome& outcome) const {
  v1::StreamCloudsResponse response = FrameOutcomeToProto(outcome);
  response.set_frame(frame.number);
  if (frame.message.has_frame_stamp()) {
    *response.mutable_frame_stamp() = frame.message.frame_stamp();
  }
  response.set_world_uid(world_->uid());
  return response;
}

void StreamCloudsCall::Answer(std::int64_t number, v1::StreamCloudsResponse response) {
  const std::lock_guard lock(mutex_);
  answers_.emplace(number, std::move(response));
}

void StreamCloudsCall::OnDone() {
  // A deleted world may be freed with its last stream: not on gRPC's thread.
  runtime_.live.TryPush([self = std::move(self_)] {});
}

}  // namespace cwm::server
