#include "perception/interpret_scene.h"

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "perception/assemble_interpretation.h"
#include "perception/cloud/measured_points.h"
#include "perception/cloud/parallel_for.h"
#include "perception/diagnose_input.h"
#include "perception/hypotheses/model_hypotheses.h"
#include "perception/object_notes.h"
#include "perception/refinement/attach/attach_handles.h"
#include "perception/refinement/attach/attach_spouts.h"
#include "perception/refinement/complete/complete_below.h"
#include "perception/refinement/complete/cut_rims.h"
#include "perception/refinement/passes.h"
#include "perception/segmentation/segment_scene.h"

namespace cwm::perception {
namespace {

class Stopwatch {
 public:
  explicit Stopwatch(std::vector<StageTime>& stages) : stages_(stages) {}
  void Done(std::string_view stage) {
    const auto now = std::chrono::steady_clock::now();
    const std::chrono::duration<double, std::milli> elapsed = now - start_;
    stages_.push_back({std::string(stage), elapsed.count()});
    start_ = now;
  }

 private:
  std::vector<StageTime>& stages_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

absl::Status CheckOptions(const InterpretOptions& options) {
  if (options.up_C && !(options.up_C->allFinite() && options.up_C->norm() > 0)) {
    return absl::InvalidArgumentError(absl::StrCat("options.up_C is (", options.up_C->x(), ", ",
                                                   options.up_C->y(), ", ", options.up_C->z(),
                                                   "): must be finite and of positive length"));
  }
  if (options.X_WC && !options.X_WC->matrix().allFinite()) {
    return absl::InvalidArgumentError("options.X_WC is not finite: must be a rigid transform");
  }
  for (const std::string& name : options.disabled_passes) {
    const std::vector<std::string> names = PassNames();
    if (std::ranges::count(names, name) == 0) {
      return absl::InvalidArgumentError(absl::StrCat(
          "options.disabled_passes has \"", name, "\": must be of ", absl::StrJoin(names, ", ")));
    }
  }
  return absl::OkStatus();
}

bool IsEnabled(const InterpretOptions& options, std::string_view pass) {
  return std::ranges::count(options.disabled_passes, pass) == 0;
}

WorldFloor FloorOf(const InterpretOptions& options) {
  const bool given = options.X_WC && options.X_WC_source == InterpretOptions::PoseSource::kGiven;
  return given ? WorldFloor::kKnown : WorldFloor::kUnknown;
}

std::string InSensorFrame(const SegmentedScene& scene, const Vector3& direction_L) {
  const Vector3 direction_C = scene.R_LC.transpose() * direction_L;
  return absl::StrFormat("(%.2f, %.2f, %.2f)", direction_C.x(), direction_C.y(), direction_C.z());
}

void WarnOfSegmentation(const SegmentedScene& scene, InterpretReport& report) {
  if (scene.up_source == UpSource::kNoPlane) {
    report.warnings.push_back("no plane tells where up is: the sensor's own axes are taken");
  }
  if (scene.up_source == UpSource::kBarePlane) {
    report.warnings.push_back(
        "up is taken from a plane that nothing stands on and that may be a wall");
  }
  if (scene.up_source == UpSource::kDoubtful) {
    report.warnings.push_back(
        absl::StrCat("up is taken as ", InSensorFrame(scene, Vector3::UnitZ()),
                     " in the sensor's frame, but ", InSensorFrame(scene, *scene.alternative_up),
                     " is nearly as likely: give up, or the sensor's pose, to settle it"));
  }
  if (scene.supports.empty()) {
    report.warnings.push_back("no support found: all points are residual geometry");
  }
}

// Steps 1 to 5: normals, table candidates, their planes and polygons, and objects on them.
absl::StatusOr<SegmentedScene> Segment(const PointCloud& cloud, const InterpretOptions& options,
                                       const Work& work, InterpretReport& report,
                                       Stopwatch& watch) {
  absl::StatusOr<MeasuredPoints> measured = CollectMeasured(cloud, options.noise, work);
  if (!measured.ok()) return measured.status();
  report.points_in = cloud.size();
  report.points_finite = measured->oriented.size() + measured->beyond_range;
  report.points_rejected = measured->beyond_range;
  if (measured->beyond_range > 0) {
    report.warnings.push_back(absl::StrFormat(
        "%d points lie beyond the range of %s, %g m: they belong to nothing",
        measured->beyond_range, RangeOf(options.noise.model).sensor,
        cloud.organised() ? RangeOf(options.noise.model).farthest_m : kWidestMap_m));
  }
  const auto at_sensor =
      std::ranges::count_if(cloud.points, [](const Eigen::Vector3f& p) { return p.isZero(0); });
  if (at_sensor > 0) {
    report.warnings.push_back(absl::StrCat(
        at_sensor, " points are at the sensor's own place (0, 0, 0): taken for no returns"));
  }
  SegmentOptions segment_options{.R_LC = std::nullopt,
                                 .up_C = options.up_C,
                                 .clustering = options.clustering,
                                 .stage_done = [&](std::string_view s) { watch.Done(s); }};
  if (options.X_WC) segment_options.R_LC = options.X_WC->linear();
  return SegmentScene(*std::move(measured), segment_options, work);
}

// Merged views have larger errors, and give no information about the space before their points.
ModelingOptions ModelingOptionsOf(const InterpretOptions& options, const SegmentedScene& scene) {
  ModelingOptions modeling{options.noise, options.modeler};
  if (!scene.sight) {
    modeling.noise.registration_sigma_m = kRegistration_m;
    modeling.modeler.from_viewpoint = false;
  }
  return modeling;
}

SceneState AttachCutOffParts(SceneState state, const InterpretOptions& options, const Work& work,
                             InterpretReport& report) {
  if (IsEnabled(options, kAttachHandles)) {
    const FoundHandles found = FindCutOffHandles(state, work);
    if (!found.all_searched) {
      report.warnings.push_back(
          "too many objects touch to look for handles of each in all others: some may be missed");
    }
    state = Attach(state, found.transfers);
  }
  if (IsEnabled(options, kAttachSpouts)) state = Attach(state, FindSpouts(state, work));
  return state;
}

// Completes the hidden parts of refined shapes, and cuts rounded rims.
SceneState Complete(SceneState state, const InterpretOptions& options, const Work& work) {
  std::vector<ModelPtr> models;
  if (IsEnabled(options, kCompleteBelow)) {
    for (const HypothesisPtr& hypothesis : state.hypotheses()) {
      models.push_back(CompleteBelow(state, *hypothesis));
    }
    state = state.WithModels(models);
  }
  if (!IsEnabled(options, kCutRims)) return state;
  models.assign(state.hypotheses().size(), nullptr);
  ParallelFor(models.size(), 1, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      models[k] = CutRoundedRims(state, *state.hypotheses()[k], work);
    }
  });
  return state.WithModels(models);
}

// The limits that were reached for single objects.
std::vector<std::string> LimitsReached(const RefinedScene& refined, const SceneState& completed) {
  std::vector<ObjectNote> notes;
  for (std::size_t k = 0; k < completed.hypotheses().size(); ++k) {
    for (const std::string& note : completed.hypotheses()[k]->model->object.notes) {
      notes.emplace_back(k + 1, note);
    }
  }
  for (const auto& [id, note] : refined.notes) {
    const bool lives = refined.state.Find(id) != nullptr;
    notes.emplace_back(lives ? refined.state.IndexOf(id) + 1 : 0, note);
  }
  return NotesByKind(notes);
}

// Section III of the paper, step by step.
absl::StatusOr<SceneInterpretation> Interpret(const PointCloud& cloud, InterpretOptions options,
                                              const Work& work) {
  options.noise = NoiseIn(cloud, options.noise);
  if (absl::Status status = CheckOptions(options); !status.ok()) return status;
  SceneInterpretation result;
  Stopwatch watch(result.report.stages);

  absl::StatusOr<SegmentedScene> scene = Segment(cloud, options, work, result.report, watch);
  if (!scene.ok()) return scene.status();
  result.X_WC.linear() = scene->R_LC;
  if (options.X_WC) result.X_WC = *options.X_WC;
  result.pose_is_guess =
      scene->up_source != UpSource::kGiven && scene->up_source != UpSource::kSupport;
  const SceneState segmented =
      AttachCutOffParts(SceneState(*std::move(scene)), options, work, result.report);
  const SegmentedScene& measured = segmented.measured();
  result.seen_from_origin = measured.sight.has_value();

  // Steps 6 and 7: shapes and handles, and refinement of the hypotheses by them.
  const ModelingOptions modeling = ModelingOptionsOf(options, measured);
  options.noise = modeling.noise;
  const HypothesisModeler modeler(measured, work);
  std::optional<ModelledScene> modelled;
  InputDiagnosis diagnosis;
  ParallelInvoke(
      work, [&] { modelled = ModelHypotheses(segmented, modeler, modeling, work); },
      [&] { diagnosis = DiagnoseInput(cloud, measured, options); });
  RefinedScene refined{.state = modelled->state};
  if (!modelled->is_shapeless && options.clustering != Clustering::kNone) {
    refined = Refine(modelled->state, RefinementPasses(), options.disabled_passes,
                     {.options = modeling, .modeler = modeler, .work = work});
  }
  const SceneState completed = Complete(refined.state, options, work);

  // Step 8: the hybrid model of the scene, in the world.
  result.labels.assign(cloud.size(), 0);
  AssembleInterpretation(completed,
                         {.X_WL = Pose(Eigen::Translation3d(result.X_WC.translation())),
                          .floor = FloorOf(options),
                          .surface = options.surface},
                         work, result);
  watch.Done("shapes");
  std::ranges::move(LimitsReached(refined, completed), std::back_inserter(result.report.warnings));
  std::ranges::move(diagnosis.warnings, std::back_inserter(result.report.warnings));
  result.scale_is_implausible = diagnosis.scale_is_implausible;
  WarnOfSegmentation(measured, result.report);
  std::ranges::move(modelled->warnings, std::back_inserter(result.report.warnings));
  return result;
}

}  // namespace

absl::StatusOr<SceneInterpretation> InterpretScene(const PointCloud& cloud,
                                                   const InterpretOptions& options,
                                                   std::stop_token stop) {
  try {
    return Interpret(cloud, options,
                     {.max_threads = options.max_threads,
                      .threads_now = options.threads_now,
                      .stop = std::move(stop),
                      .on_chunk = options.on_chunk});
  } catch (const Stopped& stopped) {
    return absl::CancelledError(stopped.what());
  }
}

}  // namespace cwm::perception
