#include "server/core/ingest.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "perception/sensor_up.h"
#include "server/core/error.h"
#include "server/core/ingest_plan.h"
#include "server/core/scan_plausibility.h"
#include "server/core/stale_changes.h"
#include "server/core/unchanged_view.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::WorldObjectPtr;
using perception::SceneInterpretation;

// chosen: how often the scan is matched, always without the writer's turn, so that no writer waits
// for a scan. After the last match, objects that were changed meanwhile are left as they are, so
// that an ingest ends even under a stream of other writes.
constexpr int kMatchTries = 3;
// chosen: how often a scan is interpreted again because its sensor got another pose meanwhile. The
// first scan of a sensor may lose once to another first scan, and once to a given pose.
constexpr int kInterpretTries = 3;
constexpr std::size_t kMaxSensorNameBytes = 128;  // the limit of worlds and objects, too

absl::Status Cancelled() { return absl::CancelledError("ingest: the caller went away"); }

bool SamePose(const std::optional<SensorPose>& a, const std::optional<SensorPose>& b) {
  if (!a.has_value() || !b.has_value()) return a.has_value() == b.has_value();
  return a->X_WC.matrix() == b->X_WC.matrix() && a->given == b->given;
}

// The pose to interpret the scan with. A given pose wins, even if it was given with an earlier
// scan. The estimate of an earlier scan is used unless this request gives an up direction that
// contradicts it, or only segments, in which case the answer must not depend on earlier scans.
// Empty: the pose is estimated anew.
std::optional<SensorPose> PoseFor(const IngestRequest& request,
                                  const std::optional<SensorPose>& kept) {
  if (request.options.X_WC.has_value()) return SensorPose{*request.options.X_WC, true};
  if (!kept.has_value() || kept->given) return kept;
  if (request.mode == IngestMode::kSegmentOnly) return std::nullopt;
  const std::optional<Vector3>& up_C = request.options.up_C;
  if (up_C.has_value() && !perception::AgreesWithUp(kept->X_WC, *up_C)) return std::nullopt;
  return kept;
}

// An object that belongs to no world: what a scan showed, under a name of its own. Its geometry has
// only the model, prepared for no engine.
WorldObjectPtr ProvisionalObject(std::string name, const Detections& detections, int d,
                                 std::string supported_by) {
  collision::WorldObject object;
  object.name = std::move(name);
  object.kind = detections.kind(d);
  object.owner = collision::Owner::kPerception;
  object.X_WO = detections.X_WO(d);
  object.geometry = std::make_shared<const collision::PreparedModel>(
      collision::PreparedModel{.model = detections.model(d), .parts = {}});
  object.supported_by = std::move(supported_by);
  return collision::Place(std::move(object));
}

perception::Work WorkOf(const perception::InterpretOptions& options, std::stop_token stop) {
  return {.max_threads = options.max_threads,
          .threads_now = options.threads_now,
          .stop = std::move(stop),
          .on_chunk = options.on_chunk};
}

// Adds the time until it is stopped to a stage.
class StageClock {
 public:
  explicit StageClock(double& sum_ms) : sum_ms_(sum_ms) {}
  void Stop() {
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - start_;
    sum_ms_ += elapsed.count();
  }

 private:
  double& sum_ms_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

enum class PoseOrigin { kTold, kThisScan };  // given or kept, or estimated from this scan

class IngestRun {
 public:
  IngestRun(World& world, const IngestRequest& request, SceneInterpretation scene,
            std::optional<SensorPose> kept_pose, PoseOrigin origin, std::stop_token stop)
      : world_(world),
        request_(request),
        scene_(std::move(scene)),
        kept_pose_(std::move(kept_pose)),
        origin_(origin),
        stop_(std::move(stop)),
        detections_(scene_),
        geometry_(detections_) {}

  IngestOutcome SegmentOnly() {
    const SnapshotPtr snapshot = world_.Snapshot();
    IngestOutcome outcome = Start(snapshot->revision());
    std::map<std::string, int> numbers;
    std::vector<std::string> names;
    for (int d = 0; d < detections_.size(); ++d) {
      const std::string stem = StemOf(detections_.kind(d));
      names.push_back(absl::StrCat(stem, "_", ++numbers[stem]));
    }
    for (int d = 0; d < detections_.size(); ++d) {
      const int supporter = detections_.supported_by(d);
      Append(outcome, d,
             ProvisionalObject(names[static_cast<std::size_t>(d)], detections_, d,
                               supporter < 0 ? "" : names[static_cast<std::size_t>(supporter)]));
    }
    return outcome;
  }

  // Empty if the sensor got another pose since the scan was interpreted.
  absl::StatusOr<std::optional<IngestOutcome>> Write() {
    for (int attempt = 1;; ++attempt) {
      Match(world_.Tip());
      StageClock preparing(geometry_ms_);
      const absl::Status prepared =
          geometry_.PrepareFor(match_, request_.mode, WorkOf(request_.options, stop_));
      if (!prepared.ok()) return prepared;
      if (const absl::Status kept =
              world_.KeepGeometry(geometry_.prepared(), Durability::kObserved);
          !kept.ok()) {
        return kept;
      }
      preparing.Stop();
      refusal_ = Refusal::kNone;
      StageClock publishing(publish_ms_);
      absl::StatusOr<WriteOutcome> written = world_.Update(
          [&](const SnapshotPtr& latest) {
            return Changes(latest, attempt < kMatchTries ? IfStale::kRefuse : IfStale::kLeaveOut);
          },
          request_.write,
          {.facts = [&](const collision::WorldSnapshot& next) { return Facts(next); },
           .reply =
               [&](const WriteOutcome& done) {
                 return std::make_shared<const IngestOutcome>(Outcome(done));
               },
           .durability = Durability::kObserved});
      publishing.Stop();
      if (refusal_ == Refusal::kOtherPose) return std::nullopt;
      if (refusal_ == Refusal::kStale) continue;
      if (!written.ok()) return written.status();
      if (written->replayed) return Replayed(*written);
      IngestOutcome outcome = Outcome(*written);
      KeepView(written->snapshot, outcome);
      return outcome;
    }
  }

  static absl::StatusOr<IngestOutcome> Replayed(const WriteOutcome& first) {
    if (first.ingest != nullptr) {
      IngestOutcome outcome = *first.ingest;
      outcome.replayed = true;
      return outcome;
    }
    // The id was used for other changes whose digest happens to be the same.
    return MakeError(absl::StatusCode::kFailedPrecondition,
                     "request_id: was used before for changes, not for a scan",
                     {.reason = "REQUEST_ID_REUSED"});
  }

 private:
  enum class IfStale { kRefuse, kLeaveOut };
  enum class Refusal { kNone, kStale, kOtherPose };

  void Match(SnapshotPtr snapshot) {
    StageClock matching(association_ms_);
    match_ = MatchScene(std::move(snapshot), scene_, request_.cloud, request_.options.noise);
    matching.Stop();
  }

  // Must be called under the writer's turn.
  absl::StatusOr<std::vector<collision::Change>> Changes(const SnapshotPtr& latest,
                                                         IfStale if_stale) {
    if (!request_.options.X_WC.has_value() &&
        !SamePose(world_.SensorPoseOf(request_.sensor), kept_pose_)) {
      refusal_ = Refusal::kOtherPose;
      return absl::AbortedError("the sensor got another pose");
    }
    if (const absl::Status plausible = CheckScan(); !plausible.ok()) return plausible;
    changed_ = latest;
    absl::StatusOr<IngestPlan> plan =
        PlanIngest(match_, detections_, request_.mode, geometry_,
                   [&](const std::string& stem) { return world_.ReserveName(stem); });
    if (!plan.ok()) return plan.status();
    plan_ = *std::move(plan);
    if (latest == match_.snapshot) return plan_.changes;
    const ChangesSince since(*match_.snapshot, *latest);
    const std::vector<std::string> stale = since.DropFrom(plan_.changes);
    if (!stale.empty() && if_stale == IfStale::kRefuse) {
      refusal_ = Refusal::kStale;
      return absl::AbortedError("the world moved on");
    }
    LeaveOut(stale);
    return plan_.changes;
  }

  void LeaveOut(const std::vector<std::string>& stale) {
    if (stale.empty()) return;
    for (auto* names : {&plan_.added, &plan_.moved, &plan_.replaced, &plan_.removed}) {
      std::erase_if(*names, [&](const std::string& name) {
        return std::ranges::find(stale, name) != stale.end();
      });
    }
    left_out_ = absl::StrCat(
        "objects were changed by others while the scan was interpreted, and "
        "left as they are: ",
        absl::StrJoin(stale, ", "));
  }

  // True if the sender states what was only estimated before: then what the world knows was placed
  // by the estimate, and may all be wrong.
  bool CorrectsPose() const {
    const bool states = request_.options.X_WC.has_value()
                            ? !request_.in_world_frame
                            : request_.options.up_C.has_value() && origin_ == PoseOrigin::kThisScan;
    if (!states || kept_pose_.has_value()) return states && !kept_pose_->given;
    // A sensor without a kept pose, but with a scan, had one that was only a guess.
    const std::vector<KeptScan> scans = world_.scans().List();
    return std::ranges::any_of(
        scans, [&](const KeptScan& scan) { return scan.sensor == request_.sensor; });
  }

  // Adding scans do not change what is there, so that only their scale is a danger.
  absl::Status CheckScan() const {
    if (request_.force || (CorrectsPose() && !scene_.scale_is_implausible)) return absl::OkStatus();
    const bool by_estimate = origin_ == PoseOrigin::kTold && kept_pose_ && !kept_pose_->given;
    if (by_estimate && !request_.options.X_WC && !scene_.seen_from_origin) {
      const absl::Status confirmed = CheckConfirmsSupport(match_);
      if (!confirmed.ok()) return confirmed;
    }
    if (request_.mode == IngestMode::kAdd && !scene_.scale_is_implausible) return absl::OkStatus();
    return CheckPlausible(match_, scene_);
  }

  std::optional<NamedSensorPose> SensorPoseToKeep() const {
    if (request_.in_world_frame) return std::nullopt;
    if (request_.kept_pose.has_value()) {
      return NamedSensorPose{request_.sensor, *request_.kept_pose};
    }
    if (request_.options.X_WC.has_value()) {
      return NamedSensorPose{request_.sensor, {*request_.options.X_WC, true}};
    }
    if (origin_ != PoseOrigin::kThisScan || scene_.pose_is_guess) return std::nullopt;
    return NamedSensorPose{request_.sensor, {X_WC(), false}};
  }

  WriteFacts Facts(const collision::WorldSnapshot& next) const {
    WriteFacts facts;
    const auto add = [&](const std::vector<std::string>& names, bool is_new) {
      for (const std::string& name : names) {
        if (next.Find(name) == nullptr) continue;
        facts.sightings.push_back({.name = name, .is_new = is_new});
      }
    };
    add(plan_.added, true);
    add(plan_.moved, true);
    add(plan_.replaced, true);
    add(plan_.kept, false);
    for (std::size_t i = 0; i < scene_.supports.size(); ++i) {
      for (Sighting& sighting : facts.sightings) {
        if (sighting.name == plan_.names[i]) sighting.reachable = scene_.supports[i].reachable;
      }
    }
    facts.seen_at = request_.taken_at();
    facts.sensor_pose = SensorPoseToKeep();
    return facts;
  }

  // Pose of the frame of the sender's points. The scene's frame has its origin at the viewpoint.
  Pose X_WC() const { return scene_.X_WC * Eigen::Translation3d(-request_.viewpoint_C); }

  IngestOutcome Start(collision::Revision revision) const {
    IngestOutcome outcome;
    outcome.revision = revision;
    outcome.X_WC = X_WC();
    outcome.report = scene_.report;
    outcome.labels = scene_.labels;
    for (const perception::DetectedSupport& support : scene_.supports) {
      outcome.support_reachable.push_back(support.reachable);
    }
    return outcome;
  }

  void Append(IngestOutcome& outcome, int d, WorldObjectPtr object) const {
    (d < detections_.supports() ? outcome.supports : outcome.objects).push_back(std::move(object));
  }

  IngestOutcome Outcome(const WriteOutcome& written) const {
    IngestOutcome outcome = Start(written.revision);
    for (int d = 0; d < detections_.size(); ++d) {
      const std::string& name = plan_.names[static_cast<std::size_t>(d)];
      WorldObjectPtr object = name.empty() ? nullptr : written.snapshot->Find(name);
      Append(outcome, d, object != nullptr ? object : ProvisionalObject(name, detections_, d, ""));
    }
    for (const auto& [stage, elapsed_ms] : {std::pair{"association", association_ms_},
                                            {"geometry", geometry_ms_},
                                            {"publish", publish_ms_}}) {
      outcome.report.stages.push_back({stage, elapsed_ms});
    }
    if (const auto drift = DriftWarning(match_); drift && request_.mode == IngestMode::kUpdate) {
      outcome.report.warnings.push_back(*drift);
    }
    if (!left_out_.empty()) outcome.report.warnings.push_back(left_out_);
    outcome.added = plan_.added;
    outcome.moved = plan_.moved;
    outcome.replaced = plan_.replaced;
    outcome.removed = plan_.removed;
    outcome.kept = plan_.kept;
    outcome.occluded = plan_.occluded;
    return outcome;
  }

  // Keeps the view, so that the next scan need not be interpreted if it shows the same.
  void KeepView(const SnapshotPtr& after, IngestOutcome& outcome) {
    const bool is_guess = origin_ == PoseOrigin::kThisScan && scene_.pose_is_guess;
    if (is_guess || !left_out_.empty()) return;
    double keep_ms = 0;
    StageClock keeping(keep_ms);
    KeptViewPtr view =
        MakeKeptView(request_, PoseOfScan(), outcome, scene_.report,
                     {.matched = match_.snapshot, .changed = changed_, .after = after});
    if (view != nullptr) world_.views().Keep(std::move(view));
    keeping.Stop();
    outcome.report.stages.push_back({"keep", keep_ms});
  }

  // The pose that the next scan of this sensor is interpreted with, if it tells none or the same.
  SensorPose PoseOfScan() const {
    if (origin_ == PoseOrigin::kThisScan) return {X_WC(), false};
    return *PoseFor(request_, kept_pose_);
  }

  World& world_;
  const IngestRequest& request_;
  const SceneInterpretation scene_;
  const std::optional<SensorPose> kept_pose_;  // the world's when the scan was interpreted
  const PoseOrigin origin_;
  const std::stop_token stop_;
  const Detections detections_;
  DetectionGeometry geometry_;
  SceneMatch match_;
  SnapshotPtr changed_;  // that the changes were applied to
  IngestPlan plan_;
  std::string left_out_;  // a warning; empty: nothing was
  double association_ms_ = 0, geometry_ms_ = 0, publish_ms_ = 0;
  Refusal refusal_ = Refusal::kNone;
};

absl::StatusOr<SceneInterpretation> InterpretWith(const std::optional<SensorPose>& pose,
                                                  const IngestRequest& request,
                                                  const Interpreter& interpret,
                                                  const std::stop_token& stop) {
  perception::InterpretOptions options = request.options;
  using Source = perception::InterpretOptions::PoseSource;
  if (pose.has_value()) {
    options.X_WC = pose->X_WC * Eigen::Translation3d(request.viewpoint_C);
    options.X_WC_source = pose->given ? Source::kGiven : Source::kEstimated;
  }
  absl::StatusOr<SceneInterpretation> scene = interpret(request.cloud, options, stop);
  if (scene.ok() && stop.stop_requested()) return Cancelled();
  return scene;
}

// The reply to a scan that shows its sensor's last view unchanged; empty if it does not, or if it
// may not. Adds the time that telling took to `compare_ms`.
absl::StatusOr<std::optional<IngestOutcome>> IngestUnchanged(World& world,
                                                             const IngestRequest& request,
                                                             const std::optional<SensorPose>& kept,
                                                             double& compare_ms) {
  if (request.force || request.mode == IngestMode::kSegmentOnly) return std::nullopt;
  const KeptViewPtr view = world.views().Find(request.sensor);
  const std::optional<SensorPose> pose = PoseFor(request, kept);
  if (view == nullptr || !pose.has_value()) return std::nullopt;
  StageClock comparing(compare_ms);
  std::optional<IngestOutcome> outcome = MatchUnchanged(*view, request, *pose, *world.Tip());
  comparing.Stop();
  if (!outcome.has_value()) return std::nullopt;
  outcome->report.stages.push_back({"compare", compare_ms});
  double publish_ms = 0;
  StageClock publishing(publish_ms);
  bool has_changed = false;
  const auto check = [&](const SnapshotPtr& latest) -> absl::StatusOr<std::vector<Change>> {
    const bool is_told = request.options.X_WC.has_value();
    has_changed = !HoldsAsSeen(*latest, *view) ||
                  (!is_told && !SamePose(world.SensorPoseOf(request.sensor), kept));
    if (has_changed) return absl::AbortedError("the view changed meanwhile");
    return std::vector<Change>();
  };
  const absl::StatusOr<WriteOutcome> written = world.Update(
      check, request.write,
      {.facts = [&](const collision::WorldSnapshot&) { return SightingsOf(*view, request); },
       .reply =
           [&](const WriteOutcome& done) {
             outcome->revision = done.revision;
             return std::make_shared<const IngestOutcome>(*outcome);
           },
       .durability = Durability::kObserved});
  if (has_changed) return std::nullopt;
  if (!written.ok()) return written.status();
  if (written->replayed) return IngestRun::Replayed(*written);
  publishing.Stop();
  outcome->revision = written->revision;
  outcome->report.stages.push_back({"publish", publish_ms});
  return outcome;
}

absl::Status PoseIsGuess(const std::string& sensor) {
  return MakeError(
      absl::StatusCode::kFailedPrecondition,
      absl::StrCat("x_world_sensor: is absent, and this scan of \"", sensor,
                   "\" does not confirm a pose: it shows no support with objects that tells where "
                   "up is. Give the pose of the sensor, give up with a scan of it, or let it see a "
                   "table with objects"),
      {.reason = "SENSOR_POSE_UNKNOWN", .metadata = {{"sensor", sensor}}});
}

absl::Status CheckSensorName(const std::string& sensor) {
  if (sensor.size() <= kMaxSensorNameBytes) return absl::OkStatus();
  return InvalidField(
      "sensor",
      absl::StrCat("has ", sensor.size(), " characters, must have at most ", kMaxSensorNameBytes));
}

}  // namespace

absl::StatusOr<IngestOutcome> Ingest(World& world, const IngestRequest& request,
                                     const Interpreter& interpret, std::stop_token stop) {
  if (const absl::Status valid = CheckSensorName(request.sensor); !valid.ok()) return valid;
  WriteOptions write = request.write;
  if (request.mode == IngestMode::kSegmentOnly) write.request_id.clear();  // writes nothing
  absl::StatusOr<std::optional<WriteOutcome>> decided = world.Precheck(write);
  if (!decided.ok()) return decided.status();
  if (decided->has_value()) return IngestRun::Replayed(**decided);
  double compare_ms = 0;  // with the sensor's last view
  for (int attempt = 1; attempt <= kInterpretTries; ++attempt) {
    const std::optional<SensorPose> kept = world.SensorPoseOf(request.sensor);
    absl::StatusOr<std::optional<IngestOutcome>> unchanged =
        IngestUnchanged(world, request, kept, compare_ms);
    if (!unchanged.ok()) return unchanged.status();
    if (unchanged->has_value()) return **std::move(unchanged);
    const std::optional<SensorPose> pose = PoseFor(request, kept);
    absl::StatusOr<SceneInterpretation> scene = InterpretWith(pose, request, interpret, stop);
    if (!scene.ok()) return scene.status();
    if (request.needs_confirmed_pose && !pose.has_value() && scene->pose_is_guess) {
      return PoseIsGuess(request.sensor);
    }
    if (compare_ms > 0) {
      std::vector<perception::StageTime>& stages = scene->report.stages;
      stages.insert(stages.begin(), {"compare", std::exchange(compare_ms, 0)});
    }
    IngestRun run(world, request, *std::move(scene), kept,
                  pose.has_value() ? PoseOrigin::kTold : PoseOrigin::kThisScan, stop);
    if (request.mode == IngestMode::kSegmentOnly) return run.SegmentOnly();
    absl::StatusOr<std::optional<IngestOutcome>> outcome = run.Write();
    if (!outcome.ok()) return outcome.status();
    if (outcome->has_value()) return **std::move(outcome);
  }
  return MakeError(absl::StatusCode::kAborted,
                   absl::StrCat("sensor: the pose of \"", request.sensor,
                                "\" changes faster than scans are interpreted"),
                   {.reason = "SENSOR_POSE_CHANGED", .metadata = {{"sensor", request.sensor}}});
}

}  // namespace cwm::server
