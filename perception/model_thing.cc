#include "perception/model_thing.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "perception/cloud/quantile.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/complete_hidden.h"
#include "perception/explained_points.h"
#include "perception/model/object_modeler.h"
#include "perception/thing_sample.h"

namespace cwm::perception {
namespace {

constexpr float kAssociationSpacing_m = 0.004f;  // as DetectedObject::points_L promises
constexpr int kPointsPerPiece = 512;             // of a microsecond or less
constexpr double kFewLeft = 0.1;  // of the points of one solid, as the modeler allows

using Points = std::vector<std::uint32_t>;

Vector3 MeanOf(const OrientedPoints& points) {
  Vector3 sum = Vector3::Zero();
  for (const Eigen::Vector3f& p : points.points) sum += p.cast<double>();
  return sum / static_cast<double>(points.size());
}

TriangleMesh Moved(TriangleMesh mesh, const Pose& X_OL) {
  for (Vector3& v : mesh.vertices) v = X_OL * v;
  return mesh;
}

Points PointsOfPart(const ObjectModel& found, std::int32_t part) {
  Points members;
  for (std::uint32_t k = 0; k < found.part_of_point.size(); ++k) {
    if (found.part_of_point[k] == part) members.push_back(k);
  }
  return members;
}

std::vector<char> NearShapes(const OrientedPoints& points, const ObjectModel& found,
                             const Work& work) {
  PollEvery poll(work, kPointsPerPiece);
  std::vector<char> near(points.size(), 0);
  for (std::size_t k = 0; k < points.size(); ++k) {
    poll();
    near[k] = NearAnyShape(found.shapes, found.part_of_point[k], points.points[k].cast<double>(),
                           ExplainedWithin_m(points.sigma_m[k]));
  }
  return near;
}

// What is added to the model of one thing, and which of its points that explains.
class ModelBuilder {
 public:
  ModelBuilder(const OrientedPoints& points, const Pose& X_OL, std::vector<char> explained,
               const SurfaceOptions& options, const Work& work)
      : points_(points),
        X_OL_(X_OL),
        explained_(std::move(explained)),
        options_(options),
        work_(work) {}

  void AddHandles(const ObjectModel& found) {
    for (std::size_t h = 0; h < found.handles.size(); ++h) {
      Handle handle = found.handles[h];
      const Points members =
          PointsOfPart(found, static_cast<std::int32_t>(found.shapes.size() + h));
      if (!members.empty()) handle.surface = MeshOf(members);
      handle.axis_O = X_OL_.linear() * handle.axis_O;
      handle.bounds.X_FS = X_OL_ * handle.bounds.X_FS;
      model_.handles.push_back(std::move(handle));
    }
  }

  // Points that no shape explains, and those whose shape, once bounded, does not reach them.
  void AddSurface() {
    Points remaining;
    for (std::uint32_t k = 0; k < points_.size(); ++k) {
      if (!explained_[k]) remaining.push_back(k);
    }
    if (remaining.empty()) return;
    Mesh mesh = MeshOf(remaining);
    if (!mesh.mesh || mesh.mesh->triangles.empty()) return;
    model_.surfaces.push_back({std::move(mesh), static_cast<int>(remaining.size())});
  }

  void AddShapes(std::vector<ShapePart> shapes) {
    for (ShapePart& part : shapes) {
      part.X_OS = X_OL_ * part.X_OS;
      model_.shapes.push_back(std::move(part));
    }
  }

  std::uint64_t explained() const {
    return static_cast<std::uint64_t>(std::count(explained_.begin(), explained_.end(), 1));
  }
  HybridModel Take() {
    model_.point_count = static_cast<int>(points_.size());
    return std::move(model_);
  }

 private:
  // Meshes the members; those that lie near their mesh are explained.
  Mesh MeshOf(const Points& members) {
    Surface surface = ReconstructSurface(Subset(points_, members), options_, work_);
    for (std::uint32_t k : surface.explained) explained_[members[k]] = 1;
    return MakeMesh(Moved(std::move(surface.mesh), X_OL_));
  }

  const OrientedPoints& points_;
  const Pose& X_OL_;
  std::vector<char> explained_;
  const SurfaceOptions& options_;
  const Work& work_;
  HybridModel model_;
};

// What hides its foot may seem to carry it.
struct Standing {
  std::optional<Pose> X_LSupport;  // nothing: on nothing known
  ObjectModel found;
  bool reaches_support = false;
};

double UnexplainedShare(const ObjectModel& found) {
  return static_cast<double>(std::ranges::count(found.part_of_point, kUnexplained)) /
         static_cast<double>(found.part_of_point.size());
}

Standing ModelStanding(const OrientedPoints& points, const SegmentedScene& scene, std::size_t index,
                       const SceneRays& rays, const InterpretOptions& options, const Work& work) {
  const SegmentedThing& thing = scene.things[index];
  const auto model = [&](const std::optional<Pose>& X_LSupport) {
    return ModelObject(points, X_LSupport, options.noise, options.modeler, work,
                       rays.Past(index, X_LSupport, work));
  };
  const std::optional<Pose> X_LSupport = WhatItStandsOn(scene, thing);
  Standing best{X_LSupport, model(X_LSupport)};
  if (!X_LSupport || !(thing.foot_height_m > 0) || options.modeler.in_haste) return best;
  const double left = UnexplainedShare(best.found);
  // One solid is right already: of 31 things in simulated scenes that seem to rest on others, 26 are.
  if (best.found.shapes.size() == 1 && left <= kFewLeft) return best;
  Standing lower{X_LSupport, {}, true};
  lower.X_LSupport->translate(Vector3(0, 0, -thing.foot_height_m));
  lower.found = model(lower.X_LSupport);
  const bool is_simpler =
      lower.found.shapes.size() <= best.found.shapes.size() && UnexplainedShare(lower.found) < left;
  return is_simpler ? lower : best;
}

// All counts are those of the measured points.
HybridModel InMeasuredPoints(HybridModel model, const ThingSample& sample) {
  const auto scale = [&sample](int& count) {
    count = static_cast<int>(sample.Scaled(static_cast<std::uint64_t>(count)));
  };
  scale(model.point_count);
  for (ShapePart& part : model.shapes) {
    if (part.fit) scale(part.fit->inlier_count);
  }
  for (Handle& handle : model.handles) scale(handle.point_count);
  for (SurfacePart& part : model.surfaces) scale(part.point_count);
  return model;
}

// Steps 7 and 8 for the points of a sample whose shapes are found.
ModelledThing HybridOf(Standing standing, const ThingSample& sample, const OrientedPoints& points,
                       const InterpretOptions& options, const Work& work) {
  ObjectModel& found = standing.found;
  ModelledThing out;
  out.reaches_support = standing.reaches_support;
  out.X_LO.translation() = MeanOf(points);
  const Pose X_OL = out.X_LO.inverse(Eigen::Isometry);

  // Step 7: surfaces for what is left.
  ModelBuilder builder(points, X_OL, NearShapes(points, found, work), options.surface, work);
  builder.AddHandles(found);
  builder.AddSurface();

  // Step 8: the hybrid model.
  builder.AddShapes(std::move(found.shapes));
  out.explained = sample.Scaled(builder.explained());
  out.model = std::make_shared<HybridModel>(InMeasuredPoints(builder.Take(), sample));
  out.part_of_point = sample.OfAll(found.part_of_point, work);
  out.notes = std::move(found.notes);
  const float spacing_m = std::max(kAssociationSpacing_m, Median(points.sigma_m));
  const VoxelGrid thin = VoxelGrid::Build(points.points, spacing_m, work);
  for (std::size_t c = 0; c < thin.size(); ++c) out.thinned_L.push_back(thin.Centroid(c));
  return out;
}

}  // namespace

std::optional<Pose> WhatItStandsOn(const SegmentedScene& scene, const SegmentedThing& thing) {
  if (thing.supported_by < 0) return std::nullopt;
  Pose X_LSupport = scene.supports[static_cast<std::size_t>(thing.supported_by)].plate.X_FS;
  X_LSupport.translate(Vector3(0, 0, thing.foot_height_m));  // of a stack: the top below it
  return X_LSupport;
}

bool IsOneSolid(const std::vector<ShapePart>& shapes,
                const std::vector<std::int32_t>& part_of_point, double least_explained) {
  const auto explained = std::ranges::count(part_of_point, 0);
  return shapes.size() == 1 && static_cast<double>(explained) >=
                                   least_explained * static_cast<double>(part_of_point.size());
}

std::optional<ModelledThing> ModelThingIf(const WantedShapes& wanted, const SegmentedScene& scene,
                                          std::size_t index, const SceneRays& rays,
                                          const InterpretOptions& options, const Work& work) {
  const SegmentedThing& thing = scene.things[index];
  const ThingSample sample(scene, thing);
  const OrientedPoints points = sample.Points();

  // Step 6: shapes, and handles on them.
  Standing standing = thing.plates.empty()
                          ? ModelStanding(points, scene, index, rays, options, work)
                          : Standing{{}, ModelStructure(points, thing.plates, work)};
  if (!wanted(standing.found)) return std::nullopt;
  if (standing.X_LSupport && scene.sight) {
    CompleteHidden({points, *standing.X_LSupport}, *scene.sight, standing.found.shapes);
  }
  return HybridOf(std::move(standing), sample, points, options, work);
}

ModelledThing ModelThingAs(std::vector<ShapePart> shapes, const SegmentedScene& scene,
                           std::size_t index, const InterpretOptions& options, const Work& work) {
  const SegmentedThing& thing = scene.things[index];
  const ThingSample sample(scene, thing);
  const OrientedPoints points = sample.Points();
  const std::optional<Pose> X_LSupport = WhatItStandsOn(scene, thing);
  return HybridOf({X_LSupport, ModelKnown(points, X_LSupport, std::move(shapes), work)}, sample,
                  points, options, work);
}

ModelledThing ModelThing(const SegmentedScene& scene, std::size_t index, const SceneRays& rays,
                         const InterpretOptions& options, const Work& work) {
  return *ModelThingIf([](const ObjectModel&) { return true; }, scene, index, rays, options, work);
}

}  // namespace cwm::perception
