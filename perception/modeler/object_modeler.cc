#include "perception/modeler/object_modeler.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "perception/cloud/parallel_for.h"
#include "perception/cloud/tolerances.h"
#include "perception/fit/extraction.h"
#include "perception/handles/handles.h"
#include "perception/handles/vessel_handles.h"
#include "perception/primitive_fit/shrink_to_free_space.h"
#include "perception/primitive_fit/single_primitive.h"
#include "perception/primitive_fit/split_solids.h"
#include "perception/primitive_fit/unexplained_points.h"
#include "perception/solids/box_sigma.h"
#include "perception/solids/explain.h"
#include "perception/solids/extent_from_points.h"
#include "perception/solids/solid_assembly.h"
#include "perception/vessels/lying_vessel.h"
#include "perception/vessels/revolved_wall.h"
#include "perception/vessels/shell_fit.h"

namespace cwm::perception {
namespace {

// chosen: one point in this many is searched, within limits. In a scene without clusters every
// shape must keep enough points.
constexpr std::size_t kPointsPerSearchPoint = 4;

std::size_t SearchPoints(std::size_t count) {
  return std::clamp(count / kPointsPerSearchPoint, kSearchPoints, kMaxScenePoints);
}

Ground GroundOf(const std::optional<Pose>& X_LSupport, const Vector3& origin_L) {
  if (!X_LSupport) return {};
  return {.known = true,
          .up = X_LSupport->linear().col(2),
          .point = X_LSupport->translation() - origin_L};
}

std::vector<ShapePart> InLevelFrame(std::vector<Solid> solids, const FitContext& context) {
  std::vector<ShapePart> parts;
  for (Solid& solid : solids) {
    ShapePart part;
    if (std::holds_alternative<Box>(solid.shape)) {
      solid.parameter_sigma = BoxSizeSigmas(solid, context);
    }
    part.X_OS = Eigen::Translation3d(context.points.origin_L) * solid.X_MS;
    part.shape = std::move(solid.shape);
    part.role = solid.role;
    part.fit = FitQuality();
    part.fit->parameter_sigma = std::move(solid.parameter_sigma);
    part.vessel = std::move(solid.vessel);
    parts.push_back(std::move(part));
  }
  return parts;
}

// True if all points but mixed pixels on either side are explained. An object explained by one
// closed solid has no handle: a part that stands out from a wall in it, such as the end of a lying
// cup or the wall beside its rim, is its own surface.
bool ExplainsNearlyAll(const ObjectModel& model) {
  const auto unexplained = std::ranges::count(model.part_of_point, kUnexplained);
  return static_cast<double>(unexplained) <=
         2 * kMixedPixels * static_cast<double>(model.part_of_point.size());
}
bool IsSingleSolid(const ObjectModel& model) {
  return model.shapes.size() == 1 && !model.shapes.front().vessel && ExplainsNearlyAll(model);
}

// True if there is only one solid and it leaves no connected piece of points unexplained. The
// inside of a vessel would be such a piece.
bool IsOneClosedSolid(const Assembly& assembly, const FitContext& context) {
  return assembly.solids.size() == 1 && IsFullyExplained(assembly.solids, context);
}

// Returns the assembly with its shells, if they leave no points for objects beside it or for lying
// walls.
std::optional<Assembly> AsUprightVessel(const Vessel& vessel, const FitContext& context,
                                        Assembly assembly) {
  SetExtentFromPoints(context, assembly.solids);
  ReplaceByShells(vessel.walls(), context, assembly);
  const bool has_shell = std::ranges::any_of(
      assembly.solids, [](const Solid& solid) { return solid.vessel != nullptr; });
  if (!has_shell || !IsFullyExplained(assembly.solids, context)) return std::nullopt;
  return assembly;
}

bool IsEnough(const ModelPoints& thinned, const ModelerOptions& options) {
  return static_cast<double>(thinned.size()) * thinned.weight >= options.min_inliers;
}

// The points of an object that are searched, with the indices that are built once for them.
struct Searched {
  Searched(ModelPoints thinned, const std::optional<Pose>& X_LSupport)
      : points(std::move(thinned)),
        octree(points),
        connectivity(points),
        ground(GroundOf(X_LSupport, points.origin_L)) {}

  FitContext Context(const SensorNoise& noise, const ModelerOptions& options, const Work& work,
                     const PassingRays& passing) const {
    return {points,  octree, connectivity, noise,
            options, work,   ground,       FreeRaysPast(points, ground, passing)};
  }

  const ModelPoints points;
  const Octree octree;
  const Connectivity connectivity;
  const Ground ground;
};

// Fits a single closed solid with handles again, to all points but those of the handles, which pull
// at the wall that they stand out from.
void FitWithoutHandles(const OrientedPoints& points, const std::optional<Pose>& X_LSupport,
                       const SensorNoise& noise, const ModelerOptions& options, const Work& work,
                       const PassingRays& passing, ObjectModel& model) {
  if (model.handles.empty() || model.shapes.size() != 1 || model.shapes.front().vessel) return;
  std::vector<std::uint32_t> others;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (model.part_of_point[i] <= 0) others.push_back(i);
  }
  const OrientedPoints rest = Subset(points, others);
  ModelPoints thinned = SubsampleForSearch(rest, SearchPoints(rest.size()), work);
  if (!IsEnough(thinned, options)) return;
  const Searched searched(std::move(thinned), X_LSupport);
  const FitContext context = searched.Context(noise, options, work, passing);
  Solid solid;
  solid.X_MS = Eigen::Translation3d(-context.points.origin_L) * model.shapes.front().X_OS;
  solid.shape = model.shapes.front().shape;
  std::optional<PrimitiveFit> better = FindBetterPrimitive(context, {solid});
  if (!better) return;
  std::vector<Solid> solids = {WithParameterSigmas(*std::move(better), context)};
  ShrinkToFreeSpace(context, solids);
  model.shapes = InLevelFrame(std::move(solids), context);
  const std::vector<std::int32_t> part = ExplainPoints(rest, model.shapes, work);
  for (std::size_t k = 0; k < others.size(); ++k) model.part_of_point[others[k]] = part[k];
  MeasureQuality(points, model.part_of_point, context.points.spacing_m, model.shapes, work);
}

}  // namespace

ObjectModel ModelObject(const OrientedPoints& points, const std::optional<Pose>& X_LSupport,
                        const SensorNoise& noise, const ModelerOptions& options, const Work& work,
                        const PassingRays& passing) {
  ObjectModel model;
  model.part_of_point.assign(points.size(), kUnexplained);
  ModelPoints thinned = SubsampleForSearch(points, SearchPoints(points.size()), work);
  if (!IsEnough(thinned, options)) return model;
  const Searched searched(std::move(thinned), X_LSupport);
  const double spacing_m = searched.points.spacing_m;
  const Ground ground_L = GroundOf(X_LSupport, Vector3::Zero());
  const FitContext context = searched.Context(noise, options, work, passing);
  const bool may_be_open = SearchesAny(options) && !options.reduced_effort;
  Extraction extraction;
  std::optional<Vessel> vessel;
  ParallelInvoke(
      work, [&] { extraction = ExtractShapes(context); },
      [&] {
        if (may_be_open) vessel = Vessel::Find(points, work);
      });
  Assembly assembly = AssembleSolids(extraction, context, searched.ground);
  ReplaceBySinglePrimitive(context, assembly);
  // Solids are narrowed before the checks of what they leave over: one that rays enter explains too
  // much.
  ShrinkToFreeSpace(context, assembly.solids);
  std::optional<Assembly> with_shells;
  if (vessel) with_shells = AsUprightVessel(*vessel, context, assembly);
  if (with_shells) {
    assembly = *std::move(with_shells);
  } else {
    // Few objects are split, so lying walls are sought at the same time.
    bool is_split = false;
    std::optional<RevolvedWall> lying;
    const bool may_lie = may_be_open && !IsOneClosedSolid(assembly, context);
    ParallelInvoke(
        work, [&] { is_split = ReplaceBySplitSolids(context, assembly); },
        [&] {
          if (!may_lie) return;
          const auto standing = vessel ? vessel->walls() : std::vector<RevolvedWall>();
          lying = FindLyingWall(points, standing, AxesOf(extraction), context);
        });
    SetExtentFromPoints(context, assembly.solids);
    if (is_split) {
      vessel.reset();
    } else if (lying) {
      vessel = Vessel(points, {*std::move(lying)});
    }
    if (vessel) ReplaceByShells(vessel->walls(), context, assembly);
  }
  model.notes = std::move(assembly.notes);
  model.shapes = InLevelFrame(std::move(assembly.solids), context);
  model.part_of_point = ExplainPoints(points, model.shapes, work);
  if (IsSingleSolid(model)) vessel.reset();
  Clusters of_vessel;
  if (vessel) {
    of_vessel = HandlesOfVessel(*vessel, points, ground_L, model.shapes, model.part_of_point, work);
    RemoveFromSolids(of_vessel, model.shapes, model.part_of_point);
  }
  DropSolidsOfHandles(points, spacing_m, ground_L, model.shapes, model.part_of_point, work);
  MeasureQuality(points, model.part_of_point, spacing_m, model.shapes, work);
  AddHandles(points, of_vessel, model, work);
  // With a vessel wall, solids get no handles: the wall has already judged every protrusion.
  if (!vessel) FindHandles(points, spacing_m, ground_L, model, work);
  FitWithoutHandles(points, X_LSupport, noise, options, work, passing, model);
  // If nearly all points are explained, the wall that was seen from both sides belonged to a
  // handle, and the note is dropped.
  if (ExplainsNearlyAll(model)) std::erase(model.notes, kSeenFromBothSides);
  return model;
}

std::optional<ShapePart> ModelSingleSolid(const OrientedPoints& points, const Pose& X_LSupport,
                                          const SensorNoise& noise, const ModelerOptions& options,
                                          const Work& work) {
  ModelPoints thinned = SubsampleForSearch(points, SearchPoints(points.size()), work);
  if (!IsEnough(thinned, options)) return std::nullopt;
  const Searched searched(std::move(thinned), X_LSupport);
  const FitContext context = searched.Context(noise, options, work, {});
  const std::optional<PrimitiveFit> fit = FindBetterPrimitive(context, {});
  if (!fit) return std::nullopt;
  return InLevelFrame({fit->solid}, context).front();
}

std::optional<ShapePart> FindLyingVessel(const OrientedPoints& points,
                                         const std::optional<Pose>& X_LSupport,
                                         const std::vector<Vector3>& axes, const SensorNoise& noise,
                                         const ModelerOptions& options, const Work& work) {
  ModelPoints thinned = SubsampleForSearch(points, SearchPoints(points.size()), work);
  if (!IsEnough(thinned, options)) return std::nullopt;
  const Searched searched(std::move(thinned), X_LSupport);
  const FitContext context = searched.Context(noise, options, work, {});
  const auto wall = FindLyingWall(points, FitRevolvedWalls(points, work), axes, context);
  if (!wall) return std::nullopt;
  std::optional<Solid> shell = FitShell(*wall, context);
  return InLevelFrame({*std::move(shell)}, context).front();
}

ObjectModel ModelFromShapes(const OrientedPoints& points, const std::optional<Pose>& X_LSupport,
                            std::vector<ShapePart> shapes, const Work& work) {
  ObjectModel model;
  model.shapes = std::move(shapes);
  const double spacing_m = SubsampleForSearch(points, SearchPoints(points.size()), work).spacing_m;
  model.part_of_point = ExplainPoints(points, model.shapes, work);
  MeasureQuality(points, model.part_of_point, spacing_m, model.shapes, work);
  FindHandles(points, spacing_m, GroundOf(X_LSupport, Vector3::Zero()), model, work);
  return model;
}

ObjectModel ModelStructure(const OrientedPoints& points, const std::vector<Placed<Plate>>& plates,
                           const Work& work) {
  std::vector<ShapePart> shapes;
  for (const Placed<Plate>& plate : plates) {
    shapes.push_back({.X_OS = plate.X_FS,
                      .shape = plate.shape,
                      .role = PartRole::kCompleted,
                      .fit = FitQuality()});
  }
  return ModelFromShapes(points, std::nullopt, std::move(shapes), work);
}

}  // namespace cwm::perception
