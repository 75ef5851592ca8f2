// LiveWorld: what it tells and forgets of its sensors, and whether they agree.
#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/core/live/live_world.h"

namespace cwm::server {

absl::Status SensorUnknown(const std::string& sensor) {
  return MakeError(absl::StatusCode::kNotFound,
                   absl::StrCat("no sensor \"", sensor, "\" streams into this world"),
                   {.reason = "SENSOR_UNKNOWN", .metadata = {{"sensor", sensor}}});
}

void SensorStream::BeginTurn(Lockstep::Callback begin) {
  world_->lockstep_.Begin(std::move(begin));
}

void SensorStream::EndTurn(Lockstep::Callback end) { world_->lockstep_.End(std::move(end)); }

std::vector<LiveWorld::Session> LiveWorld::Sessions() const {
  const std::lock_guard lock(sensors_mutex_);
  std::vector<Session> sessions;
  for (const auto& [name, session] : sessions_) sessions.push_back(session);
  return sessions;
}

std::vector<SensorStatus> LiveWorld::Sensors() const {
  const Clock::time_point now = Clock::now();
  std::vector<SensorStatus> sensors;
  for (const Session& session : Sessions()) {
    SensorStatus& status = sensors.emplace_back(session->status(now));
    const std::string& name = status.calibration.sensor;
    const std::lock_guard sequence(sequencer_);
    status.estimate = agreement_.EstimateOf(name);
    status.estimate_note = agreement_.NoteOf(name);
    status.conflicts = agreement_.ConflictsOf(name);
    status.X_WC = agreement_.GivenPose(name).value_or(status.X_WC);
  }
  return sensors;
}

bool LiveWorld::Has(const std::string& sensor) const {
  const std::lock_guard lock(sensors_mutex_);
  return sessions_.contains(sensor);
}

absl::Status LiveWorld::SetSensorPose(const std::string& sensor, const Pose& X_WC) {
  for (const Session& session : Sessions()) {
    const SensorCalibration calibration = session->calibration();
    if (calibration.sensor != sensor) continue;
    if (calibration.mount.has_value()) {
      return MakeError(
          absl::StatusCode::kFailedPrecondition,
          absl::StrCat("the sensor \"", sensor, "\" is on ", calibration.mount->robot, "/",
                       calibration.mount->link, ", its place there is set by its calibration"),
          {.reason = "SENSOR_ON_ROBOT", .metadata = {{"sensor", sensor}}});
    }
    session->SetPose(X_WC);
    return absl::OkStatus();
  }
  return SensorUnknown(sensor);
}

std::optional<Pose> LiveWorld::EstimatedPose(const std::string& sensor) const {
  const std::lock_guard sequence(sequencer_);
  const auto estimate = agreement_.EstimateOf(sensor);
  return estimate ? std::optional(estimate->X_WC) : std::nullopt;
}

// The place at which the sensor's frames are compared with the world.
SensorPlace LiveWorld::UsedPlace(const std::string& sensor, const SensorPlace& given) const {
  SensorPlace used = given;
  const std::lock_guard sequence(sequencer_);
  used.X_WC = agreement_.UsedPose(sensor, given.X_WC);
  return used;
}

// True if the frame may change the world; otherwise the outcome says why not, unless the sensor is
// still to be compared with others.
bool LiveWorld::IsTrusted(const Evidence& evidence, const Pose& X_WC_given,
                          const SensorCalibration& calibration, FrameOutcome& outcome) {
  agreement_.Add(evidence, X_WC_given, calibration);
  const SensorAgreement::Standing standing = agreement_.StandingOf(evidence.sensor);
  const bool is_trusted = standing == SensorAgreement::Standing::kTrusted;
  switch (standing) {
    case SensorAgreement::Standing::kTrusted:
      if (!agreement_.IsDisplaced(evidence.sensor)) return true;
      break;
    case SensorAgreement::Standing::kWaits:
      outcome.interpreting = true;
      return false;
    case SensorAgreement::Standing::kContradicts:
      break;
  }
  if (outcome.reason.empty()) {
    const std::vector<std::string> conflicts = agreement_.ConflictsOf(evidence.sensor);
    outcome.reason = "CALIBRATION_CONFLICT";
    outcome.message = conflicts.empty() ? "" : conflicts.front();
    if (is_trusted) {
      outcome.message += ": the frame is used at the pose at which it agrees with the others";
    }
  }
  return is_trusted;
}

void LiveWorld::StartComparison() {
  std::optional<AgreementJob> due;
  {
    const std::lock_guard sequence(sequencer_);
    due = agreement_.TakeJob();
  }
  if (!due) return;
  const auto job = std::make_shared<const AgreementJob>(*std::move(due));
  const bool is_taken = StartBeside([self = shared_from_this(), job] {
    const AgreementResult result = Compare(*job);
    {
      const std::lock_guard sequence(self->sequencer_);
      self->agreement_.Take(result);
    }
    self->StartComparison();
  });
  if (is_taken) return;
  const std::lock_guard sequence(sequencer_);
  agreement_.PutBack(*job);  // the next frame tries again
}

bool LiveWorld::StartBeside(std::function<void()> task) {
  return services_.run_beside([self = shared_from_this(), token = lockstep_.RunBeside(),
                               task = std::move(task)] { task(); });
}

bool LiveWorld::RunsBeside() const {
  const std::lock_guard sequence(sequencer_);
  return regions_asked_ > 0 || fusion_.is_running() || agreement_.is_comparing();
}

void LiveWorld::ForgetAgreement(const std::string& sensor) {
  const std::lock_guard sequence(sequencer_);
  agreement_.Forget(sensor);
  fusion_.Forget(sensor);
}

void LiveWorld::ForgetMovers(SensorSession& session) {
  const std::string sensor = session.calibration().sensor;
  const std::lock_guard sequence(sequencer_);
  const std::vector<perception::TrackChange> changes = tracker_.ForgetSensor(sensor);
  session.set_tracked(false);
  if (changes.empty()) return;
  const auto table = numbers_.TableOf(world_->Tip());
  // Fails only if the world was deleted, or if its disk is full: a later sensor or the next start
  // takes them away then.
  Publish(changes, sensor, table).status().IgnoreError();
}

void LiveWorld::ClearFacts() {
  const std::lock_guard sequence(sequencer_);
  if (!std::exchange(has_facts_, false)) return;
  const SnapshotPtr snapshot = world_->Snapshot();
  for (const collision::WorldObjectPtr& object : snapshot->objects()) {
    world_->observations().SetFacts(object->name, std::nullopt, *snapshot);
  }
}

void LiveWorld::NoteShapes(const Evidence& evidence,
                           const std::shared_ptr<const BodyTable>& table) {
  std::set<perception::BodyId> moving;
  for (const perception::BodyEvidence& body : evidence.bodies) {
    const bool rests = tracker_.FactsOf(body.id).motion == perception::Motion::kAtRest;
    if (!rests) moving.insert(body.id);
  }
  fusion_.Add(evidence, table, moving);
}

// Shapes wait until nothing new is being interpreted.
void LiveWorld::StartFusion() {
  std::optional<FusionJob> due;
  {
    const std::lock_guard sequence(sequencer_);
    if (regions_asked_ == 0) due = fusion_.TakeJob();
  }
  if (!due) return;
  due->max_threads = services_.max_threads;
  const auto job = std::make_shared<const FusionJob>(*std::move(due));
  const bool is_taken = StartBeside([self = shared_from_this(), job] {
    const auto fused =
        FuseShapes(*self->world_, *job, self->services_.interpret, self->stop_.get_token());
    self->FinishFusion(*job, fused.value_or(FrameChanges()));
  });
  if (!is_taken) FinishFusion(*job, {});  // the shapes stay as one sensor sees them
}

// The next frame of one of the sensors tells what was replaced and removed.
void LiveWorld::FinishFusion(const FusionJob& job, const FrameChanges& fused) {
  Session teller;
  {
    const std::lock_guard lock(sensors_mutex_);
    const auto found = sessions_.find(job.views.front().sensor);
    if (found != sessions_.end()) teller = found->second;
  }
  if (teller != nullptr) {
    const std::lock_guard comparing(teller->comparison.mutex);
    teller->comparison.interpreted.Append(fused);
  }
  const std::lock_guard sequence(sequencer_);
  fusion_.Finish(fused.replaced);
}

std::vector<std::shared_ptr<const DisplayFrame>> LiveWorld::FramesAfter(
    std::uint64_t number, const std::string& sensor) const {
  std::vector<std::shared_ptr<const DisplayFrame>> frames;
  for (const Session& session : Sessions()) {
    auto frame = session->newest_frame();
    if (frame == nullptr || frame->number <= number) continue;
    if (sensor.empty() || frame->sensor == sensor) frames.push_back(std::move(frame));
  }
  std::ranges::sort(frames, {}, [](const auto& frame) { return frame->number; });
  return frames;
}

}  // namespace cwm::server
