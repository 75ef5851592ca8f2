#include "perception/interpret_scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "collision/geometry/signed_distance.h"
#include "perception/cloud/measured_points.h"
#include "perception/cloud/parallel_for.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/explained_points.h"
#include "perception/model/object_modeler.h"
#include "perception/scene/segment_scene.h"

namespace cwm::perception {
namespace {

// The arm's reach of the paper (section IV), above the world's floor.
constexpr double kLowestReach_m = 0.35, kHighestReach_m = 1.5;
constexpr double kObservedCell_m =
    0.01;  // wider than the pixels' spacing at the far end of a table
constexpr float kAssociationSpacing_m = 0.004f;
constexpr int kPointsPerPiece = 512;  // of a microsecond or less
constexpr std::uint32_t kMostSupportLabels = 9, kMostPartLabels = 9;

using Points = std::vector<std::uint32_t>;

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

OrientedPoints Subset(const OrientedPoints& all, const Points& members) {
  OrientedPoints some;
  some.viewpoint = all.viewpoint;
  for (std::uint32_t i : members) {
    some.points.push_back(all.points[i]);
    some.normals.push_back(all.normals[i]);
    some.sigma_m.push_back(all.sigma_m[i]);
    some.normal_sigma_rad.push_back(all.normal_sigma_rad[i]);
    some.cloud_index.push_back(all.cloud_index[i]);
  }
  return some;
}

Vector3 MeanOf(const OrientedPoints& points) {
  Vector3 sum = Vector3::Zero();
  for (const Eigen::Vector3f& p : points.points) sum += p.cast<double>();
  return sum / static_cast<double>(points.size());
}

TriangleMesh Moved(TriangleMesh mesh, const Pose& X_OL) {
  for (Vector3& v : mesh.vertices) v = X_OL * v;
  return mesh;
}

// One thing, modelled. Everything but points_L in the object's frame, whose origin is the mean of
// its points in the level frame, axes parallel to it.
struct ModelledThing {
  Pose X_LO = Pose::Identity();
  std::shared_ptr<HybridModel> model;
  std::vector<std::int32_t> part_of_point;
  std::vector<Eigen::Vector3f> thinned_L;
  std::uint64_t explained = 0;
  std::vector<std::string> notes;
};

Points PointsOfPart(const ObjectModel& found, std::int32_t part) {
  Points members;
  for (std::uint32_t k = 0; k < found.part_of_point.size(); ++k) {
    if (found.part_of_point[k] == part) members.push_back(k);
  }
  return members;
}

class ThingModeler {
 public:
  ThingModeler(const SegmentedScene& scene, const InterpretOptions& options, const Work& work)
      : scene_(scene), options_(options), work_(work) {}

  // Step 6: shapes. Step 7: surfaces. Step 8: the hybrid model.
  ModelledThing Model(const SegmentedThing& thing) const {
    const OrientedPoints points = Subset(scene_.points, thing.points);
    std::optional<Pose> X_LSupport;
    if (thing.supported_by >= 0) {
      X_LSupport = scene_.supports[static_cast<std::size_t>(thing.supported_by)].plate.X_FS;
      X_LSupport->translate(Vector3(0, 0, thing.foot_height_m));  // of a stack: the top below it
    }
    ObjectModel found = ModelObject(points, X_LSupport, options_.noise, options_.modeler, work_);
    ModelledThing out;
    out.X_LO.translation() = MeanOf(points);
    out.notes = std::move(found.notes);
    out.model = std::make_shared<HybridModel>();
    out.model->point_count = static_cast<int>(points.size());
    std::vector<char> explained = NearShapes(points, found);
    const Pose X_OL = out.X_LO.inverse(Eigen::Isometry);
    AddHandles(points, X_OL, found, *out.model, explained);
    AddSurface(points, X_OL, *out.model, explained);
    for (ShapePart& part : found.shapes) {
      part.X_OS = X_OL * part.X_OS;
      out.model->shapes.push_back(std::move(part));
    }
    out.explained = static_cast<std::uint64_t>(std::count(explained.begin(), explained.end(), 1));
    out.part_of_point = std::move(found.part_of_point);
    const VoxelGrid thin = VoxelGrid::Build(points.points, kAssociationSpacing_m);
    for (std::size_t c = 0; c < thin.size(); ++c) out.thinned_L.push_back(thin.Centroid(c));
    return out;
  }

 private:
  std::vector<char> NearShapes(const OrientedPoints& points, const ObjectModel& found) const {
    PollEvery poll(work_, kPointsPerPiece);
    std::vector<char> near(points.size(), 0);
    for (std::size_t k = 0; k < points.size(); ++k) {
      poll();
      near[k] = NearAnyShape(found.shapes, found.part_of_point[k], points.points[k].cast<double>(),
                             ExplainedWithin_m(points.sigma_m[k]));
    }
    return near;
  }

  // Meshes the members; those that lie near their mesh are explained.
  Mesh MeshOf(const OrientedPoints& points, const Points& members, const Pose& X_OL,
              std::vector<char>& explained) const {
    Surface surface = ReconstructSurface(Subset(points, members), options_.surface, work_);
    for (std::uint32_t k : surface.explained) explained[members[k]] = 1;
    return MakeMesh(Moved(std::move(surface.mesh), X_OL));
  }

  void AddHandles(const OrientedPoints& points, const Pose& X_OL, ObjectModel& found,
                  HybridModel& model, std::vector<char>& explained) const {
    for (std::size_t h = 0; h < found.handles.size(); ++h) {
      Handle& handle = found.handles[h];
      const Points members =
          PointsOfPart(found, static_cast<std::int32_t>(found.shapes.size() + h));
      if (!members.empty()) handle.surface = MeshOf(points, members, X_OL, explained);
      handle.axis_O = X_OL.linear() * handle.axis_O;
      handle.bounds.X_FS = X_OL * handle.bounds.X_FS;
      model.handles.push_back(std::move(handle));
    }
  }

  // Points that no shape explains, and those whose shape, once bounded, does not reach them.
  void AddSurface(const OrientedPoints& points, const Pose& X_OL, HybridModel& model,
                  std::vector<char>& explained) const {
    Points remaining;
    for (std::uint32_t k = 0; k < points.size(); ++k) {
      if (!explained[k]) remaining.push_back(k);
    }
    if (remaining.empty()) return;
    Mesh mesh = MeshOf(points, remaining, X_OL, explained);
    if (!mesh.mesh || mesh.mesh->triangles.empty()) return;
    model.surfaces.push_back({std::move(mesh), static_cast<int>(remaining.size())});
  }

  const SegmentedScene& scene_;
  const InterpretOptions& options_;
  const Work& work_;
};

double Area_m2(const Plate& plate) {
  double area = std::abs(SignedArea_m2(plate.outline));
  for (const Polygon& hole : plate.holes) area -= std::abs(SignedArea_m2(hole));
  return area;
}

// The quality of a top face; what is below it is completed.
FitQuality QualityOf(const SegmentedSupport& support, const OrientedPoints& points) {
  FitQuality fit;
  const Pose X_SL = support.plate.X_FS.inverse(Eigen::Isometry);
  double squares = 0;
  std::vector<std::pair<int, int>> cells;
  for (std::uint32_t i : support.points) {
    const Vector3 local = X_SL * points.points[i].cast<double>();
    squares += local.z() * local.z();
    fit.max_residual_m = std::max(fit.max_residual_m, std::abs(local.z()));
    cells.emplace_back(static_cast<int>(std::floor(local.x() / kObservedCell_m)),
                       static_cast<int>(std::floor(local.y() / kObservedCell_m)));
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  fit.observed_fraction = std::min(1.0, static_cast<double>(cells.size()) * kObservedCell_m *
                                            kObservedCell_m / Area_m2(support.plate.shape));
  fit.inlier_count = static_cast<int>(support.points.size());
  fit.inlier_ratio = 1;
  fit.rms_m = std::sqrt(squares / std::max<double>(1, fit.inlier_count));
  return fit;
}

DetectedSupport MakeSupport(const SegmentedSupport& segmented, const OrientedPoints& points,
                            const Pose& X_WL, bool floor_is_known) {
  DetectedSupport support;
  support.X_WO = X_WL * segmented.plate.X_FS;
  support.point_count = static_cast<int>(segmented.points.size());
  auto model = std::make_shared<HybridModel>();
  model->point_count = support.point_count;
  model->shapes.push_back({.X_OS = Pose::Identity(),
                           .shape = segmented.plate.shape,
                           .role = PartRole::kCompleted,
                           .fit = QualityOf(segmented, points)});
  support.model = std::move(model);
  if (floor_is_known) {
    const double top = support.X_WO.translation().z();
    support.reachable = top >= kLowestReach_m && top <= kHighestReach_m;
  }
  return support;
}

std::uint64_t ExplainedBySupport(const SegmentedSupport& support, const OrientedPoints& points,
                                 const Work& work) {
  PollEvery poll(work, kPointsPerPiece);
  const Pose X_SL = support.plate.X_FS.inverse(Eigen::Isometry);
  std::uint64_t explained = 0;
  for (std::uint32_t i : support.points) {
    poll();
    const Vector3 local = X_SL * points.points[i].cast<double>();
    const double tolerance = ExplainedWithin_m(points.sigma_m[i]);
    const Vector2 p = local.head<2>();
    if (std::abs(local.z()) > tolerance) continue;
    if (Contains(support.plate.shape.outline, p)) {
      ++explained;  // over the top face; holes hold no points of the support
    } else {
      explained += SignedDistance_m(support.plate.shape, local) <= tolerance;
    }
  }
  return explained;
}

void LabelSupports(const SegmentedScene& scene, std::vector<std::uint32_t>& labels) {
  for (std::uint32_t s = 0; s < scene.supports.size(); ++s) {
    for (std::uint32_t i : scene.supports[s].points) {
      labels[scene.points.cloud_index[i]] = std::min(s + 1, kMostSupportLabels);
    }
  }
}

void LabelThing(const SegmentedScene& scene, std::uint32_t index,
                const std::vector<std::int32_t>& part_of_point,
                std::vector<std::uint32_t>& labels) {
  const std::vector<std::uint32_t>& points = scene.things[index].points;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const auto part = static_cast<std::uint32_t>(part_of_point[k] + 1);
    labels[scene.points.cloud_index[points[k]]] =
        10 * (index + 2) + std::min(part, kMostPartLabels);
  }
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

bool KnowsFloor(const InterpretOptions& options) {
  return options.X_WC && options.X_WC_source == InterpretOptions::PoseSource::kGiven;
}

void AddWarnings(const SegmentedScene& scene, InterpretReport& report) {
  if (!scene.up_known) {
    report.warnings.push_back("no plane tells where up is: the sensor's own axes are taken");
  }
  if (scene.supports.empty()) {
    report.warnings.push_back("no support found: all points are residual geometry");
  }
}

absl::StatusOr<SceneInterpretation> Interpret(const PointCloud& cloud,
                                              const InterpretOptions& options, const Work& work) {
  if (absl::Status status = CheckOptions(options); !status.ok()) return status;
  SceneInterpretation result;
  InterpretReport& report = result.report;
  Stopwatch watch(report.stages);
  absl::StatusOr<MeasuredPoints> measured = CollectMeasured(cloud, options.noise, work);
  if (!measured.ok()) return measured.status();
  report.points_in = cloud.size();
  report.points_finite = measured->oriented.size();

  SegmentOptions segment_options{.R_LC = std::nullopt,
                                 .up_C = options.up_C,
                                 .stage_done = [&](std::string_view s) { watch.Done(s); }};
  if (options.X_WC) segment_options.R_LC = options.X_WC->linear();
  absl::StatusOr<SegmentedScene> scene = SegmentScene(*std::move(measured), segment_options, work);
  if (!scene.ok()) return scene.status();
  result.X_WC.linear() = scene->R_LC;
  if (options.X_WC) result.X_WC = *options.X_WC;
  Pose X_WL = Pose::Identity();
  X_WL.translation() = result.X_WC.translation();

  result.labels.assign(cloud.size(), 0);
  LabelSupports(*scene, result.labels);
  for (const SegmentedSupport& support : scene->supports) {
    result.supports.push_back(MakeSupport(support, scene->points, X_WL, KnowsFloor(options)));
    report.points_explained += ExplainedBySupport(support, scene->points, work);
  }

  std::vector<ModelledThing> modelled(scene->things.size());
  const ThingModeler modeler(*scene, options, work);
  ParallelFor(modelled.size(), 1, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      modelled[k] = modeler.Model(scene->things[k]);
    }
  });
  watch.Done("shapes");

  for (std::uint32_t k = 0; k < modelled.size(); ++k) {
    ModelledThing& thing = modelled[k];
    LabelThing(*scene, k, thing.part_of_point, result.labels);
    DetectedObject object;
    object.supported_by = scene->things[k].supported_by;
    object.rests_on = scene->things[k].rests_on;
    object.kind = object.supported_by >= 0 ? DetectedKind::kObject : DetectedKind::kResidual;
    object.X_WO = X_WL * thing.X_LO;
    object.model = std::move(thing.model);
    object.points_L = std::move(thing.thinned_L);
    result.objects.push_back(std::move(object));
    report.points_explained += thing.explained;
    for (std::string& note : thing.notes) {
      report.warnings.push_back(absl::StrCat("object ", k + 1, ": ", note));
    }
  }
  report.points_rejected = scene->rejected.size();
  AddWarnings(*scene, report);
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
