#include "server/core/live/live_world.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "perception/live/unmodelled_blocks.h"
#include "server/core/error.h"
#include "server/core/live/frame_stages.h"

namespace cwm::server {
namespace {

using perception::BodyEvidence;
using perception::FrameEvidence;
using perception::Stamp;

// chosen: sightings are told to the second.
constexpr auto kSightingPeriod = std::chrono::seconds(1);

FrameOutcome Refused(const Pose& X_WC, std::string reason, std::string message) {
  return {.fate = FrameFate::kRefused,
          .reason = std::move(reason),
          .message = std::move(message),
          .X_WC = X_WC};
}

FrameOutcome RefusedBy(const absl::Status& status) {
  std::string reason = DetailsOf(status).reason;
  if (reason.empty()) reason = absl::StatusCodeToString(status.code());
  return Refused(Pose::Identity(), std::move(reason), std::string(status.message()));
}

FrameOutcome Stale(Stamp stamp, Stamp newest) {
  const std::chrono::duration<double, std::milli> late = newest - stamp;
  return Refused(Pose::Identity(), "STALE_FRAME",
                 late.count() > 0
                     ? absl::StrCat("frame_stamp: is ", late.count(),
                                    " ms older than the newest processed frame of its sensor, "
                                    "must be newer")
                     : "frame_stamp: is that of the newest processed frame of its sensor, must be "
                       "newer");
}

SensorFacts FactsFrom(const perception::TrackedFacts& tracked) {
  SensorFacts facts{.identity_certain = tracked.identity_certain, .carried_by = tracked.carried_by};
  switch (tracked.motion) {
    case perception::Motion::kAtRest:
      facts.motion = SensorFacts::Motion::kAtRest;
      break;
    case perception::Motion::kMoving:
      facts.motion = SensorFacts::Motion::kMoving;
      break;
    case perception::Motion::kSettling:
      facts.motion = SensorFacts::Motion::kSettling;
      break;
  }
  switch (tracked.visibility) {
    case perception::Visibility::kVisible:
      facts.visibility = SensorFacts::Visibility::kVisible;
      break;
    case perception::Visibility::kOccluded:
      facts.visibility = SensorFacts::Visibility::kOccluded;
      break;
    case perception::Visibility::kStale:
      facts.visibility = SensorFacts::Visibility::kStale;
      break;
    case perception::Visibility::kLost:
      facts.visibility = SensorFacts::Visibility::kLost;
      break;
  }
  return facts;
}

bool HasReturn(const perception::PixelCounts& pixels) {
  std::int64_t others = 0;
  for (std::size_t c = 0; c < pixels.size(); ++c) {
    if (c != static_cast<std::size_t>(perception::PixelClass::kMissing)) others += pixels[c];
  }
  return others > 0;
}

std::optional<PlaceAtStamp> PlaceBefore(const SensorComparison& comparison) {
  if (!comparison.X_WC.has_value() || !comparison.newest.has_value()) return std::nullopt;
  return PlaceAtStamp{.X_WC = *comparison.X_WC, .stamp = *comparison.newest};
}

}  // namespace

SensorStream::SensorStream(std::shared_ptr<LiveWorld> world, std::shared_ptr<SensorSession> session,
                           std::uint64_t number)
    : world_(std::move(world)), session_(std::move(session)), number_(number) {}

SensorStream::~SensorStream() { session_->End(number_, Clock::now()); }

absl::StatusOr<FrameOutcome> SensorStream::Process(const LiveFrame& frame) {
  auto outcome = world_->Process(session_, number_, frame);
  if (outcome.ok() && outcome->fate == FrameFate::kRefused) session_->NoteRefused();
  return outcome;
}

bool SensorStream::MustIngestFirst(bool frame_has_pose) const {
  return server::MustIngestFirst(*world_->world(), *session_, frame_has_pose, Clock::now());
}

std::optional<perception::DepthCamera> SensorStream::camera() const {
  const std::lock_guard lock(session_->comparison.mutex);
  if (session_->comparison.view == nullptr) return std::nullopt;
  return session_->comparison.camera;
}

LiveWorld::LiveWorld(std::shared_ptr<World> world, LiveServices services)
    : world_(std::move(world)), services_(std::move(services)) {}

absl::StatusOr<std::unique_ptr<SensorStream>> LiveWorld::Open(const SensorCalibration& calibration,
                                                              EndStream end) {
  if (calibration.mount.has_value()) {
    if (auto status = CheckMount(*calibration.mount, *world_->Tip()); !status.ok()) return status;
  }
  Session session;
  {
    const std::lock_guard lock(sensors_mutex_);
    if (has_ended_) return end_reason_;
    const auto found = sessions_.find(calibration.sensor);
    if (found != sessions_.end()) {
      session = found->second;
    } else {
      if (auto status = MakeRoomForSensor(); !status.ok()) return status;
      session = std::make_shared<SensorSession>(calibration);
      sessions_.emplace(calibration.sensor, session);
    }
  }
  PrepareRobots();
  const std::uint64_t number = session->Begin(calibration, std::move(end));
  return std::make_unique<SensorStream>(shared_from_this(), std::move(session), number);
}

bool LiveWorld::PrepareRobots() {
  bool are_prepared = true;
  const SnapshotPtr snapshot = world_->Tip();
  for (const collision::WorldRobotPtr& robot : snapshot->robots()) {
    are_prepared &= shapes_.Of(robot->robot) != nullptr;
  }
  return are_prepared;
}

// Under the lock of the sensors. Sensors that are gone make room, the longest silent one first.
absl::Status LiveWorld::MakeRoomForSensor() {
  if (sessions_.size() < kMaxSensors) return absl::OkStatus();
  auto oldest = sessions_.end();
  for (auto it = sessions_.begin(); it != sessions_.end(); ++it) {
    if (it->second->is_streaming() || it->second->is_tracked()) continue;
    const bool is_older =
        oldest == sessions_.end() || it->second->last_active() < oldest->second->last_active();
    if (is_older) oldest = it;
  }
  if (oldest == sessions_.end()) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     absl::StrCat("the world has ", sessions_.size(),
                                  " sensors, it may have at most ", kMaxSensors),
                     {.reason = "TOO_MANY_SENSORS"});
  }
  sessions_.erase(oldest);
  return absl::OkStatus();
}

RobotsSeen LiveWorld::FindRobots(SensorComparison& comparison, const SensorCalibration& calibration,
                                 const LiveFrame& frame, const SensorPlace& place,
                                 const BodyTable& table,
                                 std::span<const perception::KnownBody> bodies,
                                 std::span<const RobotAtFrame> robots) {
  if (robots.empty()) return {};
  const perception::ExpectedView& expected = comparison.view->Expect(bodies, place.X_WC);
  return comparison.robots.Mask({.camera = &comparison.camera,
                                 .X_WC = place.X_WC,
                                 .V_WC = place.V_WC,
                                 .image = frame.image.get(),
                                 .noise = calibration.noise,
                                 .expected_m = expected.depth_m(),
                                 .expected_body = expected.body()},
                                frame.exposure, table, bodies, robots, shapes_);
}

absl::StatusOr<FrameOutcome> LiveWorld::Process(const Session& session, std::uint64_t stream,
                                                const LiveFrame& frame) {
  FrameStages stages(frame);
  SensorComparison& comparison = session->comparison;
  const std::lock_guard comparing(comparison.mutex);
  if (absl::Status owns = session->CheckOwner(stream); !owns.ok()) {
    const std::lock_guard lock(sensors_mutex_);
    return has_ended_ ? end_reason_ : owns;
  }
  if (comparison.newest.has_value() && frame.stamp <= *comparison.newest) {
    FrameOutcome stale = Stale(frame.stamp, *comparison.newest);
    stale.revision = world_->Snapshot()->revision();
    return stale;
  }
  const absl::StatusOr<std::optional<FrameChanges>> first = IngestFirstFrame(
      *world_, *session, frame, {services_.interpret, services_.max_threads, services_.threads_now},
      stop_.get_token());
  if (!first.ok()) {
    if (absl::IsNotFound(first.status())) return first.status();  // WORLD_DELETED
    FrameOutcome refused = RefusedBy(first.status());
    refused.revision = world_->Snapshot()->revision();
    return refused;
  }
  if (first->has_value()) stages.End("interpret");
  const SensorCalibration calibration = session->calibration();
  const std::shared_ptr<const BodyTable> table = numbers_.TableOf(world_->Tip());
  const std::vector<RobotAtFrame> robots =
      RobotsAt(*table->snapshot, world_->robot_states(), frame.stamp);
  const absl::StatusOr<SensorPlace> place =
      PlaceAt(calibration, frame, robots, PlaceBefore(comparison),
              world_->SensorPoseOf(calibration.sensor));
  if (!place.ok()) {
    FrameOutcome refused = RefusedBy(place.status());
    refused.revision = table->snapshot->revision();
    return refused;
  }
  const SensorPlace used = UsedPlace(calibration.sensor, *place);
  const bool is_placed_anew = comparison.X_WC.has_value() &&
                              comparison.X_WC->matrix() == place->X_WC.matrix() &&
                              comparison.X_WC_used.matrix() != used.X_WC.matrix();
  if (comparison.view == nullptr || comparison.camera != frame.camera || is_placed_anew) {
    comparison.view = std::make_unique<perception::SensorView>(calibration.sensor, frame.camera,
                                                               calibration.noise);
    comparison.camera = frame.camera;
  }
  std::vector<perception::KnownBody> bodies = BodiesAt(*table, robots);
  std::vector<perception::RobotLinks> links = LinksInView(robots, shapes_);
  if (!links.empty()) {
    const std::lock_guard sequence(sequencer_);
    tracker_.PlaceCarried(links, bodies);
  }
  comparison.view->Expect(bodies, used.X_WC);
  stages.End("expected");
  RobotsSeen seen = FindRobots(comparison, calibration, frame, used, *table, bodies, robots);
  stages.End("robot");
  comparison.newest = frame.stamp;
  comparison.X_WC = place->X_WC;
  comparison.X_WC_used = used.X_WC;
  FrameEvidence evidence = comparison.view->Observe(
      {.stamp = frame.stamp,
       .X_WC = used.X_WC,
       .image = frame.image,
       .pose_sigma = frame.pose_sigma.value_or(calibration.pose_sigma()),
       .may_move = frame.X_WC.has_value() || calibration.mount.has_value()},
      bodies, seen.mask);
  std::erase_if(links, [&](const perception::RobotLinks& robot) {
    return std::ranges::find(seen.at_fault, robot.robot) != seen.at_fault.end();
  });
  evidence.robots = std::move(links);
  NoteSightings(evidence, *table, comparison);
  stages.End("compare");
  FrameOutcome outcome{.reason = std::move(seen.reason), .message = std::move(seen.message)};
  outcome.X_WC = evidence.X_WC;
  outcome.robot_state_age_ms = seen.state_age_ms;
  outcome.pixels = evidence.classes->counts;
  {
    const std::lock_guard sequence(sequencer_);
    outcome.number = ++last_frame_;
    // Before the robots are prepared, nobody knows what of the frame is theirs.
    std::vector<perception::TrackChange> changes;
    if (seen.is_prepared) {
      const bool is_trusted = IsTrusted(evidence, place->X_WC, calibration, outcome);
      changes = is_trusted ? Track(evidence, table, bodies, session)
                           : tracker_.ForgetSensor(evidence.sensor);
      if (is_trusted) NoteShapes(evidence, table);
    }
    stages.End("track");
    auto written = Publish(changes, evidence.sensor, table);
    if (!written.ok()) {
      if (absl::IsNotFound(written.status())) return written.status();  // WORLD_DELETED
      FrameOutcome refused = RefusedBy(written.status());
      refused.revision = world_->Snapshot()->revision();
      return refused;
    }
    gone_.ForgetAfter(kKeepTime, frame.stamp);
    for (const collision::WorldObjectPtr& object : written->removed) gone_.Add(object, frame.stamp);
    outcome.revision = written->revision;
    outcome.changes = std::move(written->changes);
    outcome.changes.Append(std::exchange(comparison.interpreted, {}));
    if (first->has_value()) outcome.changes.Append(**first);
  }
  StartComparison();
  StartRegions();
  StartFusion();
  outcome.interpreting |= RunsBeside();
  stages.End("publish");
  const double latency_ms = Milliseconds(stages.last() - frame.received);
  const std::chrono::duration<double, std::milli> delay =
      std::chrono::system_clock::now() - frame.stamp;
  session->NoteProcessed(
      std::make_shared<const DisplayFrame>(DisplayFrame{.number = outcome.number,
                                                        .sensor = calibration.sensor,
                                                        .stamp = frame.stamp,
                                                        .X_WC = evidence.X_WC,
                                                        .camera = frame.camera,
                                                        .image = frame.image,
                                                        .classes = evidence.classes,
                                                        .revision = outcome.revision,
                                                        .latency_ms = latency_ms}),
      delay.count() - latency_ms);
  outcome.stages = stages.Take();
  if (outcome.reason.empty() && !HasReturn(outcome.pixels)) {
    outcome.reason = "NO_RETURN";
    outcome.message = absl::StrCat("no pixel has a depth from ", frame.camera.least_range_m, " to ",
                                   frame.camera.greatest_range_m, " m");
  }
  return outcome;
}

std::vector<perception::TrackChange> LiveWorld::Track(const Evidence& evidence,
                                                      const std::shared_ptr<const BodyTable>& table,
                                                      std::span<const perception::KnownBody> bodies,
                                                      const Session& session) {
  session->set_tracked(true);
  perception::StepResult step = tracker_.Step(evidence, bodies);
  for (const perception::BodyId id : step.found_again) {
    const collision::WorldObjectPtr object = table->Find(id);
    if (object != nullptr) NoteSeenAgain(*object, *table);
  }
  PublishFacts(step, *table);
  for (perception::RegionRequest& request : step.requests) {
    RegionJob job{.sensor = evidence.sensor,
                  .X_WC_given = agreement_.GivenPose(evidence.sensor).value_or(evidence.X_WC),
                  .request = std::move(request),
                  .frame = evidence,
                  .bodies = table,
                  .gone = gone_.objects(),
                  .max_threads = services_.max_threads,
                  .threads_now = services_.threads_now};
    regions_.push_back({session, std::make_shared<const RegionJob>(std::move(job))});
    ++regions_asked_;
  }
  return std::move(step.changes);
}

absl::StatusOr<LiveWritten> LiveWorld::Publish(const std::vector<perception::TrackChange>& changes,
                                               const std::string& sensor,
                                               const std::shared_ptr<const BodyTable>& table) {
  const bool has_robot_states = world_->robot_states().LeaveToFrame(Clock::now());
  if (changes.empty() && !has_robot_states) {
    return LiveWritten{.revision = world_->Snapshot()->revision()};
  }
  return Commit(*world_,
                {.bodies = table,
                 .changes = changes,
                 .sensor = sensor,
                 .takes_robot_states = has_robot_states},
                movers_);
}

void LiveWorld::PublishFacts(const perception::StepResult& step, const BodyTable& bodies) {
  for (const perception::BodyId id : step.facts_changed) {
    const collision::WorldObjectPtr object = bodies.Find(id);
    if (object == nullptr) continue;
    has_facts_ = true;
    SensorFacts facts = FactsFrom(tracker_.FactsOf(id));
    facts.identity_certain &= gone_.IsCertain(object->name);
    world_->observations().SetFacts(object->name, facts, *bodies.snapshot);
  }
}

void LiveWorld::NoteSeenAgain(const collision::WorldObject& object, const BodyTable& bodies) {
  std::vector<collision::WorldObjectPtr> lost;
  for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
    const perception::TrackedFacts facts = tracker_.FactsOf(bodies.bodies[i].id);
    if (facts.visibility == perception::Visibility::kLost) lost.push_back(bodies.objects[i]);
  }
  perception::StepResult uncertain;
  const std::vector<std::string> names = gone_.SeenAgain(object, lost);
  for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
    const bool is_named = std::ranges::find(names, bodies.objects[i]->name) != names.end();
    if (is_named) uncertain.facts_changed.push_back(bodies.bodies[i].id);
  }
  PublishFacts(uncertain, bodies);
}

// Seeing an object makes no revision, nor is it journaled.
void LiveWorld::NoteSightings(const Evidence& evidence, const BodyTable& bodies,
                              SensorComparison& at) {
  if (at.recorded.has_value() && evidence.stamp - *at.recorded < kSightingPeriod) return;
  at.recorded = evidence.stamp;
  std::vector<Sighting> sightings;
  for (const BodyEvidence& body : evidence.bodies) {
    // Half of what could be seen shows the body where it is.
    if (body.consistent == 0 || 2 * body.consistent < body.expected - body.hidden) continue;
    const collision::WorldObjectPtr object = bodies.Find(body.id);
    if (object != nullptr) sightings.push_back({.name = object->name});
  }
  world_->observations().Record(sightings, evidence.stamp, *bodies.snapshot);
}

// One region at a time: an interpretation uses all cores by itself.
void LiveWorld::StartRegions() {
  Waiting next;
  {
    const std::lock_guard sequence(sequencer_);
    if (region_runs_ || regions_.empty()) return;
    region_runs_ = true;
    next = std::move(regions_.front());
    regions_.pop_front();
  }
  const bool is_taken = StartBeside([self = shared_from_this(), next] {
    self->InterpretRegion(next.session, *next.job);
    self->StartRegions();
  });
  if (is_taken) return;
  const std::lock_guard sequence(sequencer_);
  regions_.push_front(std::move(next));  // the next frame tries again
  region_runs_ = false;
}

void LiveWorld::InterpretRegion(const Session& session, const RegionJob& job) {
  const auto same_since = [this](const RegionJob& asked) {
    const std::lock_guard sequence(sequencer_);
    return tracker_.SameSince(asked.sensor, asked.request.number);
  };
  const auto outcome =
      IngestRegion(*world_, job, services_.interpret, same_since, stop_.get_token());
  const std::shared_ptr<const BodyTable> bodies = numbers_.TableOf(world_->Tip());
  const auto drop = [](std::vector<std::int32_t>& blocks, const std::vector<std::int32_t>& these) {
    std::erase_if(blocks,
                  [&](std::int32_t block) { return std::ranges::binary_search(these, block); });
  };
  std::vector<std::int32_t> unmodelled;
  if (outcome.ok() && !job.request.is_whole_view && !job.request.is_new_surface) {
    unmodelled = perception::UnmodelledBlocks(job.frame, job.request.blocks, bodies->bodies);
    drop(unmodelled, outcome->open_blocks);
  }
  SensorComparison& comparison = session->comparison;
  const std::lock_guard comparing(comparison.mutex);
  const std::lock_guard sequence(sequencer_);
  region_runs_ = false;
  --regions_asked_;
  std::vector<std::int32_t> same =
      tracker_.Finish(job.sensor, job.request.number, outcome.ok(), unmodelled);
  if (!outcome.ok()) return;
  comparison.interpreted.Append(outcome->changes);
  for (const collision::WorldObjectPtr& object : outcome->returned) {
    NoteSeenAgain(*object, *job.bodies);
  }
  // Another camera has another view.
  if (comparison.view == nullptr || comparison.camera != job.frame.camera) return;
  std::vector<std::int32_t> interpreted = job.request.blocks;
  drop(interpreted, outcome->open_blocks);
  drop(same, outcome->open_blocks);
  drop(same, unmodelled);
  comparison.view->Remember(job.frame, interpreted, bodies->bodies);
  if (job.request.is_whole_view) comparison.view->ForgetHidden(job.frame);
  comparison.view->NoteInterpreted(job.frame, job.request.blocks);
  if (!same.empty()) comparison.view->Accept(same);
}

bool LiveWorld::ForgetGone(Clock::time_point now) {
  bool is_any_tracked = false, is_freed = false;
  for (const Session& session : Sessions()) {
    const Clock::duration silent = now - session->last_active();
    if (session->is_tracked()) {
      // A stream in lockstep may wait for its turn.
      const bool may_wait = session->is_streaming() && session->calibration().in_lockstep;
      const bool is_gone = silent > (session->is_streaming() ? Clock::duration(kSilentTime)
                                                             : Clock::duration(kGoneTime));
      if (is_gone && !may_wait) ForgetMovers(*session);
      is_any_tracked |= session->is_tracked();
    }
    if (session->is_streaming() || silent < kKeepTime) continue;
    session->Forget();
    ForgetAgreement(session->calibration().sensor);
    const std::lock_guard comparing(session->comparison.mutex);
    is_freed |= session->comparison.view != nullptr;
    session->comparison.view.reset();
    session->comparison.robots = {};
    session->comparison.X_WC.reset();
    session->comparison.newest.reset();
    session->comparison.recorded.reset();
  }
  if (!is_any_tracked) ClearFacts();
  StartRegions();
  return is_freed;
}

void LiveWorld::End(const absl::Status& reason) {
  {
    const std::lock_guard lock(sensors_mutex_);
    if (std::exchange(has_ended_, true)) return;
    end_reason_ = reason;
  }
  stop_.request_stop();
  for (const Session& session : Sessions()) session->EndOpenStream(reason);
}

}  // namespace cwm::server
