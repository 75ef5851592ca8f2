#include "collision/kernels/point_sample.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "collision/geometry/triangle.h"
#include "collision/kernels/kink.h"

namespace cwm::collision {
namespace {

bool Differ(const Vector3& a, const Vector3& b) {
  return (a - b).squaredNorm() > kSameGradient * kSameGradient;
}

// Whether the other side of the axis is as near and pulls elsewhere.
bool PullsAcrossTheAxis(const PlaneSample& sample, double radial_m) {
  if (2 * std::abs(sample.gradient.x()) <= kSameGradient) return false;
  const double distance_m = std::abs(sample.distance_m);
  if (distance_m <= kKinkReach_m) return radial_m <= kKinkReach_m;
  // A foot on the axis is the other side's too.
  const double foot_m = radial_m - sample.distance_m * sample.gradient.x();
  if (foot_m <= kKinkReach_m) return false;
  const double other_m = std::sqrt(distance_m * distance_m + 4 * radial_m * foot_m);
  return other_m - distance_m <= kKinkReach_m;
}

struct FacePlane {
  double height_m;
  Vector3 normal;
};

// Whether a face of another direction than the highest one is as high. Below the surface of a convex
// solid the highest face is the nearest.
bool FacesPullTwoWays(const TriangleMesh& hull, const Vector3& p) {
  FacePlane highest{-std::numeric_limits<double>::infinity(), Vector3::UnitZ()};
  const auto for_each_face = [&](const auto& visit) {
    for (const TriangleMesh::Triangle& t : hull.triangles) {
      const Vector3 &a = hull.vertices[t[0]], &b = hull.vertices[t[1]], &c = hull.vertices[t[2]];
      const std::optional<Vector3> normal = SureNormal(a, b, c);
      if (normal) visit(FacePlane{normal->dot(p - a), *normal});
    }
  };
  for_each_face([&](const FacePlane& face) {
    if (face.height_m > highest.height_m) highest = face;
  });
  if (highest.height_m > kKinkReach_m) return false;
  bool two_ways = false;
  for_each_face([&](const FacePlane& face) {
    two_ways = two_ways || (face.height_m >= highest.height_m - kKinkReach_m &&
                            Differ(face.normal, highest.normal));
  });
  return two_ways;
}

double RoundingAt(const Vector3& p) {
  constexpr double kShare = 1e-14;  // some dozens of roundings of the coordinates
  return kShare * std::max(1.0, p.cwiseAbs().maxCoeff());
}

Vector3 NearestOn(const TriangleCorners& t, const Vector3& p) {
  return NearestOnTriangle(t.corners[0], t.corners[1], t.corners[2], p);
}

// Whether no triangle that runs through `q`, a place of the surface, comes nearer to `p` than it.
bool IsLocallyNearest(const TriangleTree& tree, const Vector3& p, const Vector3& q) {
  const double rounding_m = RoundingAt(p);
  const double distance_m = (p - q).norm() * (1 - 1e-14) - rounding_m;
  bool nearest = true;
  tree.ForEachNear(Aabb(q, q), rounding_m, [&](const TriangleCorners& t, std::int32_t) {
    const bool through = (NearestOn(t, q) - q).norm() <= rounding_m;
    if (!through || (NearestOn(t, p) - p).norm() >= distance_m) return rounding_m;
    nearest = false;
    return TriangleTree::kEnd;
  });
  return nearest;
}

// On the surface the faces that meet there count, elsewhere the places that are nearest of all beside
// them: a neighbouring triangle's rim is not.
bool MeshPullsTwoWays(const TriangleTree& tree, const Vector3& p,
                      const TriangleTree::Nearest& nearest, WorkCounter* work) {
  const double reach_m = nearest.distance_m + kKinkReach_m;
  const bool on_surface = nearest.distance_m <= kKinkReach_m;
  const Vector3 away = (p - nearest.point) / nearest.distance_m;
  bool two_ways = false;
  tree.ForEachNear(
      Aabb(p, p), reach_m,
      [&](const TriangleCorners& t, std::int32_t) {
        const Vector3 q = NearestOn(t, p);
        const double distance_m = (p - q).norm();
        if (distance_m > reach_m) return reach_m;
        two_ways = on_surface ? Differ(t.Normal(), nearest.face_normal)
                              : Differ((p - q) / distance_m, away) && IsLocallyNearest(tree, p, q);
        return two_ways ? TriangleTree::kEnd : reach_m;
      },
      work);
  return two_ways;
}

// Whether all triangles at `q`, the place of the surface nearest to a point `p` in a solid that winds
// around it once, are left on the way from `p`: then what lies behind one of them is outside.
bool AllAreLeft(const TriangleTree& tree, const Vector3& p, const Vector3& q, int turns) {
  constexpr double kEdgeOn = 1e-9;  // sine: the side of a triangle that rounding could change
  const double rounding_m = RoundingAt(p);
  const Vector3 way = turns * (q - p).normalized();
  bool all = true;
  tree.ForEachNear(Aabb(q, q), rounding_m, [&](const TriangleCorners& t, std::int32_t) {
    if ((NearestOn(t, q) - q).norm() > rounding_m) return rounding_m;
    const Vector3 area = (t.corners[1] - t.corners[0]).cross(t.corners[2] - t.corners[0]);
    all = area.dot(way) > kEdgeOn * area.norm();
    return all ? rounding_m : TriangleTree::kEnd;
  });
  return all;
}

// Of a point in the solid.
bool IsBuried(const TriangleTree& tree, const Vector3& p, const TriangleTree::Nearest& nearest,
              WorkCounter* work) {
  constexpr double kNoDirection_m = 1e-9;  // nearer, the way to the surface is made of rounding
  if (nearest.distance_m <= kNoDirection_m) return tree.Buries(p, nearest.face_normal, work);
  const int turns = tree.Winding(p, work);
  if (std::abs(turns) == 1 && AllAreLeft(tree, p, nearest.point, turns)) return false;
  return tree.Buries(nearest.point, nearest.point - p, work);
}

}  // namespace

PointSample SampleRevolved(const PlaneProfile& profile, const Vector3& p) {
  const double radial_m = p.head<2>().norm();
  // On the axis every direction is valid.
  const Vector2 out = radial_m > 0 ? Vector2(p.head<2>() / radial_m) : Vector2::UnitX();
  const PlaneSample flat = profile.Sample({radial_m, p.z()});
  const Vector3 gradient(flat.gradient.x() * out.x(), flat.gradient.x() * out.y(),
                         flat.gradient.y());
  return {flat.distance_m, gradient, flat.kink || PullsAcrossTheAxis(flat, radial_m)};
}

PointSample SamplePlate(const PlaneProfile& outline, double thickness_m, const Vector3& p) {
  const PlaneSample side = outline.Sample(p.head<2>());
  const double half_m = 0.5 * thickness_m, height_m = p.z() + half_m;
  const double face_m = std::abs(height_m) - half_m;
  const Vector3 to_side(side.gradient.x(), side.gradient.y(), 0);
  const Vector3 to_face(0, 0, height_m >= 0 ? 1 : -1);
  const double higher_m = std::max(side.distance_m, face_m);
  const double lower_m = std::min(side.distance_m, face_m);
  const bool at_rim = higher_m <= kKinkReach_m && higher_m - lower_m <= kKinkReach_m;
  if (lower_m > 0) {  // beside the rim, above the plate
    const double distance_m = std::hypot(side.distance_m, face_m);
    return {distance_m, (side.distance_m * to_side + face_m * to_face) / distance_m,
            at_rim || side.kink};
  }
  if (side.distance_m > face_m) return {side.distance_m, to_side, at_rim || side.kink};
  const bool at_middle = face_m <= 0 && 2 * std::abs(height_m) <= kKinkReach_m;
  return {face_m, to_face, at_rim || at_middle};
}

PointSample SampleConvex(const Convex& convex, const Vector3& p) {
  const SurfacePoint at = NearestSurfacePoint(convex, p);
  // Farther than this no face is within reach, but at corners sharper than any that people make.
  constexpr double kFarFromFaces_m = 1e3 * kKinkReach_m;
  const bool near = at.signed_distance_m <= kFarFromFaces_m;
  return {at.signed_distance_m, at.normal, near && FacesPullTwoWays(*convex.hull, p)};
}

PointSample SampleMesh(const TriangleTree& tree, bool watertight, const Vector3& p,
                       double distance_m, WorkCounter* work) {
  // Who knows how far the surface is finds the place sooner.
  const auto nearest = tree.NearestPoint(p, std::abs(distance_m) + kKinkReach_m, work);
  const double sign = distance_m < 0 ? -1 : 1;
  // Below, the direction to the surface is made of rounding.
  const bool on_surface = nearest.distance_m <= kKinkReach_m;
  const Vector3 gradient =
      on_surface ? nearest.face_normal : Vector3(sign * (p - nearest.point) / nearest.distance_m);
  const bool kink = (on_surface && !watertight) || MeshPullsTwoWays(tree, p, nearest, work);
  // On a triangle within the solid the distance is none, but has a sign.
  const bool inside = watertight && std::signbit(distance_m);
  return {sign * nearest.distance_m, gradient, kink, inside && IsBuried(tree, p, nearest, work)};
}

double MeshDistance_m(const TriangleTree& tree, bool watertight, const Vector3& p,
                      double max_distance_m, WorkCounter* work) {
  if (watertight && tree.Encloses(p, work)) {
    return -tree.NearestPoint(p, std::numeric_limits<double>::infinity(), work).distance_m;
  }
  return tree.NearestPoint(p, max_distance_m, work).distance_m;
}

PlaneProfile VesselProfile(const VesselShell& shell) {
  std::vector<Vector2> points = {Vector2(0, shell.outer.front().y())};
  points.insert(points.end(), shell.outer.begin(), shell.outer.end());
  points.insert(points.end(), shell.inner.begin(), shell.inner.end());
  return PlaneProfile::Revolved(points);
}

}  // namespace cwm::collision
