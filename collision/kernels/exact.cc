#include "collision/kernels/exact.h"

#include <algorithm>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/validation.h"
#include "collision/kernels/closed_forms.h"
#include "collision/kernels/compound_pair.h"
#include "collision/kernels/convex_pair.h"
#include "collision/kernels/ray.h"

namespace cwm::collision {
namespace {

// The families of kernels, in the order in which a shape takes the role of A.
enum class Family { kHalfSpace, kMesh, kPieces };

Family FamilyOf(const ExactGeometry& geometry) {
  if (geometry.kind() == ShapeKind::kHalfSpace) return Family::kHalfSpace;
  return geometry.kind() == ShapeKind::kMesh ? Family::kMesh : Family::kPieces;
}

// Sine of the largest angle between opposite normals at which two half-spaces count as facing each
// other. derived: some tens of roundings of products of poses; over kMaxCoordinate_m their
// planes deviate by 1e-8 m from parallel ones.
constexpr double kFacingSine = 1e-14;

// Two half-spaces that face each other are separated along their normals. Others always overlap: no
// translation within the coordinates of a world separates them.
PairDistance HalfSpaceToHalfSpace(const Pose& X_AB) {
  const Vector3 normal_b = X_AB.linear().col(2), p = X_AB.translation();
  PairDistance answer{.distance_m = -kMaxCoordinate_m, .accuracy = Accuracy::kDegraded};
  if (normal_b.z() < 0 && normal_b.head<2>().norm() <= kFacingSine) {
    answer.distance_m = p.z();
    answer.accuracy = Accuracy::kExact;
  }
  answer.point_a = Vector3(p.x(), p.y(), 0);
  answer.point_b = answer.point_a + answer.distance_m * answer.normal;
  return answer;
}

// The distance of a plate and a sphere, by the point of the plate nearest to the centre. Exact for
// a separated sphere and for a convex plate; otherwise at most the minimum translation.
PairDistance PlateToSphere(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB) {
  const Vector3 centre = X_AB.translation();
  const SurfacePoint at = NearestSurfacePoint(std::get<Plate>(a.shape()), centre);
  const PairDistance core{at.signed_distance_m, centre - at.signed_distance_m * at.normal, centre,
                          at.normal};
  const PairDistance answer = WithRadii(core, 0, b.pieces().front().radius_m);
  const bool is_bound = answer.distance_m < 0 && a.pieces().size() > 1;
  return is_bound ? WithDepthBound(answer, a, b, X_AB) : answer;
}

// The pose of B in the frame of A. Translations are subtracted before they are rotated, since a
// product of poses would first round both positions if they are far from the origin of F.
Pose RelativePose(const Pose& X_FA, const Pose& X_FB) {
  const auto R_AF = X_FA.linear().transpose();
  Pose X_AB = Pose::Identity();
  X_AB.linear() = R_AF * X_FB.linear();
  X_AB.translation() = R_AF * (X_FB.translation() - X_FA.translation());
  return X_AB;
}

// The distance in the frame of A. Precondition: FamilyOf(a) <= FamilyOf(b).
PairDistance OrderedDistance(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                             const SearchLimits& limits) {
  const double max_distance_m = limits.max_distance_m;
  if (FamilyOf(a) == Family::kHalfSpace) {
    if (FamilyOf(b) == Family::kHalfSpace) return HalfSpaceToHalfSpace(X_AB);
    return HalfSpaceToAny(b, X_AB, limits);
  }
  if (FamilyOf(a) == Family::kMesh) {
    return FamilyOf(b) == Family::kMesh ? MeshToMesh(a, b, X_AB, limits)
                                        : MeshToPieces(a, b, X_AB, limits);
  }
  if (a.kind() == ShapeKind::kPlate && b.kind() == ShapeKind::kSphere) {
    return PlateToSphere(a, b, X_AB);
  }
  if (a.kind() == ShapeKind::kSphere && b.kind() == ShapeKind::kPlate) {
    return Swapped(InFrame(X_AB, PlateToSphere(b, a, X_AB.inverse())));
  }
  if (a.pieces().size() == 1 && b.pieces().size() == 1) {
    return ConvexDistance(a.pieces().front(), b.pieces().front(), X_AB, max_distance_m);
  }
  return PiecesToPieces(a, b, X_AB, limits);
}

// The distance that a ray surely runs before it can hit a bounded solid. The hit is measured from
// there, since the rounding error of the formulas grows with the square of the origin's distance.
double WayTo_m(const ExactGeometry& shape, const Ray& ray_S) {
  Aabb bounds = shape.tree() != nullptr ? shape.tree()->bounds() : Aabb();
  for (const Aabb& piece : shape.piece_bounds()) bounds.extend(piece);
  if (bounds.isEmpty()) return 0;
  const double reach_m = bounds.sizes().norm();  // half would do; the rest is a margin for rounding
  const double way_m = ray_S.direction.dot(bounds.center() - ray_S.origin) - reach_m;
  return std::clamp(way_m, 0.0, ray_S.max_distance_m);
}

}  // namespace

namespace {

PairDistance DistanceWithin(const PlacedExact& a, const PlacedExact& b,
                            const SearchLimits& limits) {
  const Pose X_AB = RelativePose(a.X_FS, b.X_FS);
  if (FamilyOf(a.geometry) <= FamilyOf(b.geometry)) {
    return InFrame(a.X_FS, OrderedDistance(a.geometry, b.geometry, X_AB, limits));
  }
  const Pose X_BA = X_AB.inverse();
  return Swapped(InFrame(b.X_FS, OrderedDistance(b.geometry, a.geometry, X_BA, limits)));
}

}  // namespace

PairDistance ExactDistance(const PlacedExact& a, const PlacedExact& b, double max_distance_m,
                           WorkCounter* work) {
  return DistanceWithin(a, b, {max_distance_m, work});
}

PairDistance ExactDistanceWithin(const PlacedExact& a, const PlacedExact& b, double max_distance_m,
                                 double slack, WorkCounter* work) {
  PairDistance answer = DistanceWithin(a, b, {max_distance_m, work, slack});
  const bool has_mesh =
      FamilyOf(a.geometry) == Family::kMesh || FamilyOf(b.geometry) == Family::kMesh;
  if (!has_mesh || !(answer.distance_m > 0) || answer.distance_m > max_distance_m) return answer;
  answer.bound_m += answer.distance_m - answer.distance_m / slack;
  answer.accuracy = std::max(answer.accuracy, Accuracy::kBounded);
  return answer;
}

std::optional<double> ExactLowerBound_m(const PlacedExact& a, const PlacedExact& b) {
  const auto is_half_space = [](const PlacedExact& shape) {
    return FamilyOf(shape.geometry) == Family::kHalfSpace;
  };
  if (is_half_space(a) || is_half_space(b)) return std::nullopt;
  if (IsConvex(a.geometry.kind()) && IsConvex(b.geometry.kind())) return std::nullopt;
  return LowerBoundByEnclosures_m(a.geometry, b.geometry, RelativePose(a.X_FS, b.X_FS));
}

bool ExactOverlap(const PlacedExact& a, const PlacedExact& b, WorkCounter* work) {
  if (FamilyOf(a.geometry) > FamilyOf(b.geometry)) return ExactOverlap(b, a, work);
  const Family family_a = FamilyOf(a.geometry), family_b = FamilyOf(b.geometry);
  const Pose X_AB = RelativePose(a.X_FS, b.X_FS);
  if (family_a == Family::kHalfSpace) {
    return family_b == Family::kHalfSpace ? HalfSpaceToHalfSpace(X_AB).distance_m < 0
                                          : HalfSpaceOverlapsAny(b.geometry, X_AB, work);
  }
  if (family_a == Family::kMesh) {
    return family_b == Family::kMesh ? MeshesOverlap(a.geometry, b.geometry, X_AB, work)
                                     : MeshOverlapsPieces(a.geometry, b.geometry, X_AB, work);
  }
  return PiecesOverlap(a.geometry, b.geometry, X_AB, work);
}

std::optional<RayHit> ExactRay(const PlacedExact& shape, const Ray& ray, WorkCounter* work) {
  const Pose X_SF = shape.X_FS.inverse();
  Ray ray_S{X_SF * ray.origin, X_SF.linear() * ray.direction, ray.max_distance_m};
  const double way_m = WayTo_m(shape.geometry, ray_S);
  ray_S.origin += way_m * ray_S.direction;
  ray_S.max_distance_m -= way_m;
  const TriangleTree* const tree = shape.geometry.tree();
  std::optional<RayHit> hit = tree == nullptr           ? CastRay(shape.geometry.shape(), ray_S)
                              : shape.geometry.IsOpen() ? tree->CastRay(ray_S, work)
                                                        : tree->CastRayAtSolid(ray_S, work);
  if (!hit) return hit;
  hit->distance_m += way_m;
  hit->normal = shape.X_FS.linear() * hit->normal;
  return hit;
}

}  // namespace cwm::collision
