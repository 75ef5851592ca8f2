#include "collision/query/sampled_part.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "collision/engines/exact_engine.h"
#include "collision/geometry/revolved_profile.h"

namespace cwm::collision {

SampledPart::SampledPart(const Obstacle& object, const Id& id)
    : id_(id),
      part_(&object.geometry->parts[static_cast<std::size_t>(id.part)]),
      shape_(&part_->shape),
      bounds_W_(&object.parts_W[static_cast<std::size_t>(id.part)].bounds_W),
      X_WP_(object.parts_W[static_cast<std::size_t>(id.part)].X_WP) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) solid_.axis[i][j] = X_WP_.linear()(j, i);
    solid_.origin[i] = X_WP_.translation()[i];
  }
  const HybridModel& model = *object.geometry->model;
  const VesselShell* const vessel =
      part_->source == PartSource::kShape
          ? model.shapes[static_cast<std::size_t>(part_->index)].vessel.get()
          : nullptr;
  if (vessel != nullptr) {
    PrepareProfile(VesselProfile(*vessel), LaneSolid::Form::kRevolved);
  } else {
    std::visit([this](const auto& shape) { Prepare(shape); }, part_->shape);
  }
}

void SampledPart::Prepare(const Sphere& sphere) {
  short_formula_ = true;
  solid_.form = LaneSolid::Form::kRound;
  solid_.size[0] = sphere.radius_m;
}

void SampledPart::Prepare(const Box& box) {
  short_formula_ = true;
  solid_.form = LaneSolid::Form::kBox;
  for (int i = 0; i < 3; ++i) solid_.size[i] = 0.5 * box.size_m[i];
}

void SampledPart::Prepare(const Cylinder& cylinder) {
  short_formula_ = true;
  solid_.form = LaneSolid::Form::kCylinder;
  solid_.size[0] = cylinder.radius_m;
  solid_.size[1] = 0.5 * cylinder.length_m;
}

void SampledPart::Prepare(const Cone& cone) {
  PrepareProfile(PlaneProfile::Revolved(ProfileOf(cone)), LaneSolid::Form::kRevolved);
}

void SampledPart::Prepare(const Capsule& capsule) {
  short_formula_ = true;
  solid_.form = LaneSolid::Form::kRound;
  solid_.size[0] = capsule.radius_m;
  solid_.size[1] = 0.5 * capsule.length_m;
}

void SampledPart::Prepare(const HalfSpace&) {
  short_formula_ = true;
  solid_.form = LaneSolid::Form::kHalfSpace;
}

void SampledPart::Prepare(const Plate& plate) {
  solid_.size[0] = plate.thickness_m;
  PrepareProfile(PlaneProfile::Outline(plate), LaneSolid::Form::kPlate);
}

void SampledPart::Prepare(const Convex&) {
  in_lanes_ = false;
  // The kernels' hull, since the triangles of a client's hull may not fit its corners
  // (ExactGeometry).
  shape_ = &ShapeOf(*part_->engines[static_cast<int>(EngineKind::kExact)]);
}

void SampledPart::Prepare(const Mesh& mesh) {
  in_lanes_ = false;
  watertight_ = mesh.watertight;
  tree_ = TreeOf(*part_->engines[static_cast<int>(EngineKind::kExact)]);
}

void SampledPart::PrepareProfile(PlaneProfile profile, LaneSolid::Form form) {
  profile_ = std::move(profile);
  solid_.form = form;
  // The edges are on the heap and keep their address if this part is moved.
  solid_.edges = profile_->edges().data();
  solid_.edge_count = static_cast<int>(profile_->edges().size());
}

void SampledPart::Measure(const BlockPoints& points_W, const BlockDistances& reach_m,
                          BlockDistances& distances_m, WorkCounter* work) const {
  if (in_lanes_) return ComputeDistances(solid_, points_W, distances_m);
  // The distance changes by at most the distance between two points, so the first point proves most
  // others too far away.
  const Vector3 first(points_W.x[0], points_W.y[0], points_W.z[0]);
  const double first_m = Distance_m(first, work);
  for (int i = 0; i < kBlockLanes; ++i) {
    const Vector3 p(points_W.x[i], points_W.y[i], points_W.z[i]);
    const double limit_m = reach_m.lane[i];
    const double at_least_m =
        std::max(first_m - (p - first).norm(), bounds_W_->exteriorDistance(p));
    distances_m.lane[i] = at_least_m > limit_m + kKinkTolerance_m
                              ? NearestLanes::kNone
                              : DistanceInShape_m(InShape(p), limit_m + 2 * kKinkTolerance_m, work);
  }
}

double SampledPart::Distance_m(const Vector3& p_W, WorkCounter* work) const {
  return DistanceInShape_m(InShape(p_W), std::numeric_limits<double>::infinity(), work);
}

CapError SampledPart::CapErrorAt(const Vector3& p_W, double reach_m) const {
  if (!HasCaps(part_->shape)) return {};
  return collision::CapErrorAt(*part_->engines[static_cast<int>(EngineKind::kExact)], InShape(p_W),
                               reach_m);
}

PointSample SampledPart::Sample(const Vector3& p_W, double distance_m, WorkCounter* work) const {
  const Vector3 p = InShape(p_W);
  PointSample sample = tree_ != nullptr ? SampleMesh(*tree_, watertight_, p, distance_m, work)
                       : profile_       ? SampleProfile(p)
                                        : SampleConvex(std::get<Convex>(*shape_), p);
  sample.gradient = X_WP_.linear() * sample.gradient;
  return sample;
}

std::optional<double> SampledPart::ExitDistance_m(const Vector3& p_W, const Vector3& direction_W,
                                                  WorkCounter* work) const {
  const Ray ray{InShape(p_W), X_WP_.linear().transpose() * direction_W};
  const auto exit = tree_->CastRayAtSolid(ray, work);
  return exit ? std::optional(exit->distance_m) : std::nullopt;
}

PointSample SampledPart::SampleProfile(const Vector3& p) const {
  return solid_.form == LaneSolid::Form::kPlate ? SamplePlate(*profile_, solid_.size[0], p)
                                                : SampleRevolved(*profile_, p);
}

double SampledPart::DistanceInShape_m(const Vector3& p, double max_distance_m,
                                      WorkCounter* work) const {
  if (tree_ != nullptr) return MeshDistance_m(*tree_, watertight_, p, max_distance_m, work);
  return profile_ ? SampleProfile(p).distance_m : SignedDistance_m(*shape_, p);
}

std::span<const SampledPart> SampledParts::PartsOf(const Obstacle& object) {
  const auto [at, is_new] = parts_.try_emplace(&object);
  if (is_new && !filter_.Skips(object)) {
    at->second.reserve(object.parts_W.size());
    const std::int32_t index = ranks_.IndexOf(&object);
    const std::int32_t by_name =
        world_.robots().empty() ? index : static_cast<std::int32_t>(world_.RankByName(object));
    for (std::size_t k = 0; k < object.parts_W.size(); ++k) {
      if (filter_.SkipsPart(object, k)) continue;
      at->second.emplace_back(object,
                              SampledPart::Id{index, static_cast<std::int32_t>(k), by_name});
    }
  }
  return at->second;
}

}  // namespace cwm::collision
