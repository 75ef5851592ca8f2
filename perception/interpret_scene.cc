#include "perception/interpret_scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <numeric>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "perception/adopt_handles.h"
#include "perception/adopt_hanging.h"
#include "perception/cloud/measured_points.h"
#include "perception/cloud/parallel_for.h"
#include "perception/complete_below.h"
#include "perception/cut_rims.h"
#include "perception/describe_support.h"
#include "perception/join_lying_vessels.h"
#include "perception/join_modelled.h"
#include "perception/join_open_boxes.h"
#include "perception/model_thing.h"
#include "perception/order_things.h"
#include "perception/part_standing.h"
#include "perception/question_input.h"
#include "perception/release_standing.h"
#include "perception/restack.h"
#include "perception/scene/segment_scene.h"
#include "perception/trade_points.h"

namespace cwm::perception {
namespace {

// As SceneInterpretation::labels promises.
constexpr std::uint32_t kMostSupportLabels = 9, kMostPartLabels = 9;

// To cut a thing may cost as much as all else that is asked of it. Of a scan, so many things may be
// cut, the largest: 25 fill an image of a Kinect, a room of many images has a quarter as many in each.
constexpr std::size_t kLeastCut = 25, kPointsPerCutThing = 640UL * 480 / 6;
std::size_t MostCutThings(const SegmentedScene& scene) {
  return std::max(kLeastCut, scene.points.size() / kPointsPerCutThing);
}
// Of these many a scene is full; what is smaller than so many others is modelled in haste.
constexpr std::size_t kUnhurriedPerCutThing = 4;
std::size_t MostUnhurriedThings(const SegmentedScene& scene) {
  return kUnhurriedPerCutThing * MostCutThings(scene);
}
// Where no more than a tenth of the largest is of shapes, the others are hardly better: they are
// meshed, no shapes are looked for. Of noise and of heaps of balls 0.98 and more is of none.
constexpr double kMostUnexplained = 0.9;
// The spacing of meshes of what is modelled in haste or meshed alone: a quarter of the triangles.
constexpr double kWiderInHaste = 2;

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

// label(k) to each of the points, in parallel: every point of the cloud is of one support or thing.
template <class Label>
void LabelEach(const SegmentedScene& scene, const std::vector<std::uint32_t>& points,
               const Work& work, std::vector<std::uint32_t>& labels, const Label& label) {
  constexpr std::size_t kPointsPerPiece = 32768;  // of 10 ns each, where the cloud is in no order
  ParallelFor(points.size(), kPointsPerPiece, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      labels[scene.points.cloud_index[points[k]]] = label(k);
    }
  });
}

void LabelSupports(const SegmentedScene& scene, const Work& work,
                   std::vector<std::uint32_t>& labels) {
  for (std::uint32_t s = 0; s < scene.supports.size(); ++s) {
    LabelEach(scene, scene.supports[s].points, work, labels,
              [&](std::size_t) { return std::min(s + 1, kMostSupportLabels); });
  }
}

void LabelThing(const SegmentedScene& scene, std::uint32_t index,
                const std::vector<std::int32_t>& part_of_point, const Work& work,
                std::vector<std::uint32_t>& labels) {
  LabelEach(scene, scene.things[index].points, work, labels, [&](std::size_t k) {
    const auto part = static_cast<std::uint32_t>(part_of_point[k] + 1);
    return 10 * (index + 2) + std::min(part, kMostPartLabels);
  });
}

absl::Status CheckOptions(const InterpretOptions& options) {
  if (options.up_C && !(options.up_C->allFinite() && options.up_C->norm() > 0)) {
    return absl::InvalidArgumentError(absl::StrCat("options.up_C is (", options.up_C->x(), ", ",
                                                   options.up_C->y(), ", ", options.up_C->z(),
                                                   "): must be finite and of positive length"));
  }
  if (options.X_WC && !options.X_WC->matrix().allFinite()) {
    return absl::InvalidArgumentError("options.X_WC is not finite: must be a rigid transform");
  }
  return absl::OkStatus();
}

WorldFloor FloorOf(const InterpretOptions& options) {
  const bool given = options.X_WC && options.X_WC_source == InterpretOptions::PoseSource::kGiven;
  return given ? WorldFloor::kKnown : WorldFloor::kUnknown;
}

void AddWarnings(const SegmentedScene& scene, bool is_shapeless, std::vector<std::string> doubts,
                 InterpretReport& report) {
  std::ranges::move(doubts, std::back_inserter(report.warnings));
  if (scene.up_source == UpSource::kNoPlane) {
    report.warnings.push_back("no plane tells where up is: the sensor's own axes are taken");
  }
  if (scene.up_source == UpSource::kBarePlane) {
    report.warnings.push_back(
        "up is taken from a plane that nothing stands on and that may be a wall");
  }
  if (scene.supports.empty()) {
    report.warnings.push_back("no support found: all points are residual geometry");
  }
  if (scene.things.size() > MostCutThings(scene)) {
    report.warnings.push_back(absl::StrCat(
        "of ", scene.things.size(), " things the largest ", MostCutThings(scene),
        " alone were looked at for things that touch: the others may be several each"));
  }
  if (is_shapeless) {
    report.warnings.push_back(absl::StrCat(
        "of the largest ", MostCutThings(scene), " of ", scene.things.size(),
        " things hardly anything is a shape: the others are meshed, no shapes were looked for"));
  } else if (scene.things.size() > MostUnhurriedThings(scene)) {
    report.warnings.push_back(absl::StrCat(
        "of ", scene.things.size(), " things all but the largest ", MostUnhurriedThings(scene),
        " were modelled in haste: some shapes of theirs may be missed, their meshes are coarser"));
  }
}

// Steps 1 to 5.
absl::StatusOr<SegmentedScene> Segment(const PointCloud& cloud, const InterpretOptions& options,
                                       const Work& work, InterpretReport& report,
                                       Stopwatch& watch) {
  absl::StatusOr<MeasuredPoints> measured = CollectMeasured(cloud, options.noise, work);
  if (!measured.ok()) return measured.status();
  report.points_in = cloud.size();
  report.points_finite = measured->oriented.size();
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
  absl::StatusOr<SegmentedScene> scene = SegmentScene(*std::move(measured), segment_options, work);
  if (scene.ok() && !AdoptHandles(*scene, work)) {
    report.warnings.push_back(
        "too many things touch to look for handles of each in all others: some may be missed");
  }
  if (scene.ok()) AdoptHanging(*scene, work);
  return scene;
}

struct DescribedScene {
  bool is_shapeless = false;  // hardly anything of the largest things is: the others are meshed
  std::vector<DescribedSupport> supports;
  std::vector<ModelledThing> things;
};

// Of the points of the things that are modelled already: the share that is of no shape or handle.
double UnexplainedShare(const std::vector<ModelledThing>& things) {
  std::size_t points = 0;
  std::ptrdiff_t unexplained = 0;
  for (const ModelledThing& thing : things) {
    points += thing.part_of_point.size();
    unexplained += std::ranges::count(thing.part_of_point, kUnexplained);
  }
  return points == 0 ? 0 : static_cast<double>(unexplained) / static_cast<double>(points);
}

// Steps 6 and 7, supports and things in parallel; supports, which may hold most of a room's points,
// and the largest things first, so that none of them is left to one thread at the end.
DescribedScene DescribeScene(const SegmentedScene& scene, const Pose& X_WL,
                             const InterpretOptions& options, const Work& work) {
  DescribedScene described;
  described.supports.resize(scene.supports.size());
  described.things.resize(scene.things.size());
  std::vector<std::size_t> order(scene.things.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return scene.things[a].points.size() > scene.things[b].points.size();
  });
  const std::size_t most_cut = MostCutThings(scene);
  const std::size_t most_unhurried = MostUnhurriedThings(scene);
  InterpretOptions uncut = options;
  uncut.modeler.part_touching = false;
  InterpretOptions in_haste = uncut;
  in_haste.modeler.in_haste = true;
  in_haste.surface.spacing_m *= kWiderInHaste;
  InterpretOptions meshed = in_haste;
  meshed.modeler = WithoutSearch(meshed.modeler);
  const auto options_of = [&](std::size_t rank) -> const InterpretOptions& {
    if (rank < most_cut) return options;
    if (described.is_shapeless) return meshed;
    return rank < most_unhurried ? uncut : in_haste;
  };
  const SceneRays rays(scene, work);
  const auto describe_support = [&](std::size_t s) {
    described.supports[s] = DescribeSupport(scene.supports[s], scene.points, X_WL, FloorOf(options),
                                            options.surface, work);
  };
  const auto describe_thing = [&](std::size_t rank) {
    const std::size_t t = order[rank];
    described.things[t] = ModelThing(scene, t, rays, options_of(rank), work);
  };
  const auto for_each = [&work](std::size_t count, const std::function<void(std::size_t)>& body) {
    ParallelFor(count, 1, work, [&body](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) body(k);
    });
  };
  const std::size_t supports = scene.supports.size();
  const std::size_t first = std::min(most_cut, order.size());
  for_each(supports + first, [&](std::size_t k) {
    if (k < supports) {
      describe_support(k);
    } else {
      describe_thing(k - supports);
    }
  });
  described.is_shapeless = order.size() > first && SearchesAny(options.modeler) &&
                           UnexplainedShare(described.things) > kMostUnexplained;
  for_each(order.size() - first, [&](std::size_t k) { describe_thing(first + k); });
  return described;
}

void AddSupports(const SegmentedScene& scene, std::vector<DescribedSupport> described,
                 const Work& work, SceneInterpretation& result) {
  LabelSupports(scene, work, result.labels);
  for (DescribedSupport& support : described) {
    result.supports.push_back(std::move(support.support));
    result.report.points_explained += support.explained;
  }
}

void AddObjects(const SegmentedScene& scene, std::vector<ModelledThing> modelled, const Pose& X_WL,
                const Work& work, SceneInterpretation& result) {
  for (std::uint32_t k = 0; k < modelled.size(); ++k) {
    ModelledThing& thing = modelled[k];
    LabelThing(scene, k, thing.part_of_point, work, result.labels);
    const std::int32_t support = scene.things[k].supported_by;
    result.objects.push_back(
        {.kind = support >= 0 ? DetectedKind::kObject : DetectedKind::kResidual,
         .X_WO = X_WL * thing.X_LO,
         .model = std::move(thing.model),
         .supported_by = support,
         .rests_on = thing.reaches_support ? -1 : scene.things[k].rests_on,
         .points_L = std::move(thing.thinned_L)});
    result.report.points_explained += thing.explained;
    for (const std::string& note : thing.notes) {
      result.report.warnings.push_back(absl::StrCat("object ", k + 1, ": ", note));
    }
  }
}

// The paper's section III, step by step.
absl::StatusOr<SceneInterpretation> Interpret(const PointCloud& cloud, InterpretOptions options,
                                              const Work& work) {
  options.noise = NoiseIn(cloud, options.noise);
  if (absl::Status status = CheckOptions(options); !status.ok()) return status;
  SceneInterpretation result;
  Stopwatch watch(result.report.stages);

  // Steps 1 to 5: normals, table candidates, their planes and polygons, what stands on them.
  absl::StatusOr<SegmentedScene> scene = Segment(cloud, options, work, result.report, watch);
  if (!scene.ok()) return scene.status();
  if (!scene->sight) {  // views that were merged
    options.noise.registration_sigma_m = kRegistration_m;
    options.modeler.from_viewpoint = false;
  }

  result.X_WC.linear() = scene->R_LC;
  if (options.X_WC) result.X_WC = *options.X_WC;
  result.pose_is_guess =
      scene->up_source == UpSource::kBarePlane || scene->up_source == UpSource::kNoPlane;
  const Pose X_WL(Eigen::Translation3d(result.X_WC.translation()));

  // Steps 6 and 7: shapes, and triangulated surfaces for what they leave.
  DescribedScene described;
  std::vector<std::string> doubts;
  DoBoth(
      work, [&] { described = DescribeScene(*scene, X_WL, options, work); },
      [&] { doubts = QuestionInput(cloud, *scene, options); });
  if (!described.is_shapeless) {
    JoinLyingVessels(options, work, *scene, described.things);
    JoinModelled(options, work, *scene, described.things);
    TradePoints(options, work, *scene, described.things);
  }
  StandAsModelled(described.things, *scene);
  PartStanding(options, work, *scene, described.things);
  Restack(options, work, *scene, described.things);
  ReleaseStanding(options, work, *scene, described.things);
  for (std::size_t s : JoinOpenBoxes(options, work, *scene, described.things)) {
    described.supports[s] = DescribeSupport(scene->supports[s], scene->points, X_WL,
                                            FloorOf(options), options.surface, work);
  }
  CompleteBelow(*scene, described.things);
  for (std::size_t t = 0; t < described.things.size(); ++t) {
    CutRoundedRims(*scene, t, described.things[t], work);
  }
  watch.Done("shapes");

  // Step 8: the hybrid model of all, in the world.
  result.labels.assign(cloud.size(), 0);
  AddSupports(*scene, std::move(described.supports), work, result);
  AddObjects(*scene, std::move(described.things), X_WL, work, result);
  result.report.points_rejected = scene->rejected.size();
  AddWarnings(*scene, described.is_shapeless, std::move(doubts), result.report);
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
                      .on_piece = options.on_piece});
  } catch (const Stopped& stopped) {
    return absl::CancelledError(stopped.what());
  }
}

}  // namespace cwm::perception
