#include "collision/kernels/point_sample.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "collision/geometry/triangle.h"
#include "collision/kernels/kink.h"

namespace cwm::collision {
namespace {

bool Differ(const Vector3& a, const Vector3& b) {
  return (a - b).squaredNorm() > kGradientTolerance * kGradientTolerance;
}

// True if the surface across the axis is about as near, with another gradient.
bool IsAxisKink(const PlaneSample& sample, double radial_m) {
  if (2 * std::abs(sample.gradient.x()) <= kGradientTolerance) return false;
  const double distance_m = std::abs(sample.distance_m);
  if (distance_m <= kKinkTolerance_m) return radial_m <= kKinkTolerance_m;
  // A foot on the axis belongs to both sides.
  const double foot_m = radial_m - sample.distance_m * sample.gradient.x();
  if (foot_m <= kKinkTolerance_m) return false;
  const double other_m = std::sqrt(distance_m * distance_m + 4 * radial_m * foot_m);
  return other_m - distance_m <= kKinkTolerance_m;
}

struct FacePlane {
  double height_m;
  Vector3 normal;
};

// True if a face with another normal is about as high as the highest one. Inside a convex solid the
// highest face is the nearest.
bool IsFaceKink(const TriangleMesh& hull, const Vector3& p) {
  FacePlane highest{-std::numeric_limits<double>::infinity(), Vector3::UnitZ()};
  const auto for_each_face = [&](const auto& visit) {
    for (const TriangleMesh::Triangle& t : hull.triangles) {
      const Vector3 &a = hull.vertices[t[0]], &b = hull.vertices[t[1]], &c = hull.vertices[t[2]];
      const std::optional<Vector3> normal = ReliableNormal(a, b, c);
      if (normal) visit(FacePlane{normal->dot(p - a), *normal});
    }
  };
  for_each_face([&](const FacePlane& face) {
    if (face.height_m > highest.height_m) highest = face;
  });
  if (highest.height_m > kKinkTolerance_m) return false;
  bool is_kink = false;
  for_each_face([&](const FacePlane& face) {
    is_kink = is_kink || (face.height_m >= highest.height_m - kKinkTolerance_m &&
                          Differ(face.normal, highest.normal));
  });
  return is_kink;
}

double RoundingAt(const Vector3& p) {
  constexpr double kShare = 1e-14;  // some dozens of roundings of the coordinates
  return kShare * std::max(1.0, p.cwiseAbs().maxCoeff());
}

Vector3 NearestOn(const TriangleCorners& t, const Vector3& p) {
  return NearestOnTriangle(t.corners[0], t.corners[1], t.corners[2], p);
}

// True if no triangle through the surface point `q` comes nearer to `p` than q itself.
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

// True if the distance has a kink at p: a triangle about as near as the nearest has another
// gradient. On the surface all triangles at p count; elsewhere only those whose nearest point is
// locally nearest, which excludes the edge of a neighbouring triangle.
bool IsMeshKink(const TriangleTree& tree, const Vector3& p, const TriangleTree::Nearest& nearest,
                WorkCounter* work) {
  const double reach_m = nearest.distance_m + kKinkTolerance_m;
  const bool on_surface = nearest.distance_m <= kKinkTolerance_m;
  const Vector3 away = (p - nearest.point) / nearest.distance_m;
  bool is_kink = false;
  tree.ForEachNear(
      Aabb(p, p), reach_m,
      [&](const TriangleCorners& t, std::int32_t) {
        const Vector3 q = NearestOn(t, p);
        const double distance_m = (p - q).norm();
        if (distance_m > reach_m) return reach_m;
        is_kink = on_surface ? Differ(t.Normal(), nearest.face_normal)
                             : Differ((p - q) / distance_m, away) && IsLocallyNearest(tree, p, q);
        return is_kink ? TriangleTree::kEnd : reach_m;
      },
      work);
  return is_kink;
}

// True if the way from `p` to `q` leaves the solid through every triangle at `q`, so that the
// points behind q are outside. p is a point in a solid with winding number `turns` = +-1, q its
// nearest surface point.
bool ExitsAllTriangles(const TriangleTree& tree, const Vector3& p, const Vector3& q, int turns) {
  constexpr double kEdgeOn = 1e-9;  // sine below which rounding could change the side of a triangle
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

// PointSample::nearest_is_interior for a point in the solid.
bool IsNearestInterior(const TriangleTree& tree, const Vector3& p,
                       const TriangleTree::Nearest& nearest, WorkCounter* work) {
  constexpr double kNoDirection_m = 1e-9;  // at less, rounding determines the way to the surface
  if (nearest.distance_m <= kNoDirection_m) return tree.IsInterior(p, nearest.face_normal, work);
  const int turns = tree.Winding(p, work);
  if (std::abs(turns) == 1 && ExitsAllTriangles(tree, p, nearest.point, turns)) return false;
  return tree.IsInterior(nearest.point, nearest.point - p, work);
}

}  // namespace

PointSample SampleRevolved(const PlaneProfile& profile, const Vector3& p) {
  const double radial_m = p.head<2>().norm();
  // On the axis every direction is valid.
  const Vector2 out = radial_m > 0 ? Vector2(p.head<2>() / radial_m) : Vector2::UnitX();
  const PlaneSample flat = profile.Sample({radial_m, p.z()});
  const Vector3 gradient(flat.gradient.x() * out.x(), flat.gradient.x() * out.y(),
                         flat.gradient.y());
  return {flat.distance_m, gradient, flat.kink || IsAxisKink(flat, radial_m)};
}

PointSample SamplePlate(const PlaneProfile& outline, double thickness_m, const Vector3& p) {
  const PlaneSample side = outline.Sample(p.head<2>());
  const double half_m = 0.5 * thickness_m, height_m = p.z() + half_m;
  const double face_m = std::abs(height_m) - half_m;
  const Vector3 to_side(side.gradient.x(), side.gradient.y(), 0);
  const Vector3 to_face(0, 0, height_m >= 0 ? 1 : -1);
  const double higher_m = std::max(side.distance_m, face_m);
  const double lower_m = std::min(side.distance_m, face_m);
  const bool at_rim = higher_m <= kKinkTolerance_m && higher_m - lower_m <= kKinkTolerance_m;
  if (lower_m > 0) {  // outside the outline and above or below the plate
    const double distance_m = std::hypot(side.distance_m, face_m);
    return {distance_m, (side.distance_m * to_side + face_m * to_face) / distance_m,
            at_rim || side.kink};
  }
  if (side.distance_m > face_m) return {side.distance_m, to_side, at_rim || side.kink};
  const bool at_middle = face_m <= 0 && 2 * std::abs(height_m) <= kKinkTolerance_m;
  return {face_m, to_face, at_rim || at_middle};
}

PointSample SampleConvex(const Convex& convex, const Vector3& p) {
  const SurfacePoint at = NearestSurfacePoint(convex, p);
  // chosen: farther outside than this no plane of a face is within reach, except at corners sharper
  // than any in real objects.
  constexpr double kFarFromFaces_m = 1e3 * kKinkTolerance_m;
  const bool near = at.signed_distance_m <= kFarFromFaces_m;
  return {at.signed_distance_m, at.normal, near && IsFaceKink(*convex.hull, p)};
}

PointSample SampleMesh(const TriangleTree& tree, bool watertight, const Vector3& p,
                       double distance_m, WorkCounter* work) {
  // The known distance limits the search for the nearest point.
  const auto nearest = tree.NearestPoint(p, std::abs(distance_m) + kKinkTolerance_m, work);
  const double sign = distance_m < 0 ? -1 : 1;
  // At smaller distances rounding determines the direction to the surface.
  const bool on_surface = nearest.distance_m <= kKinkTolerance_m;
  const Vector3 gradient =
      on_surface ? nearest.face_normal : Vector3(sign * (p - nearest.point) / nearest.distance_m);
  const bool kink = (on_surface && !watertight) || IsMeshKink(tree, p, nearest, work);
  // A point on a triangle inside the solid has the distance -0, whose sign bit says that it is
  // inside.
  const bool inside = watertight && std::signbit(distance_m);
  return {sign * nearest.distance_m, gradient, kink,
          inside && IsNearestInterior(tree, p, nearest, work)};
}

double MeshDistance_m(const TriangleTree& tree, bool watertight, const Vector3& p,
                      double max_distance_m, WorkCounter* work) {
  if (watertight && tree.Contains(p, work)) {
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
