#include "collision/kernels/mesh_hulls.h"

#include <algorithm>
#include <utility>

#include "collision/kernels/gjk.h"
#include "collision/kernels/inner_hull.h"
#include "collision/kernels/piece_distance.h"

namespace cwm::collision {
namespace {

// Largest number of vertices of a mesh with hulls. measured: quickhull takes some hundred
// milliseconds for so many; once per mesh.
constexpr std::size_t kMaxVertices = std::size_t{1} << 16;
// Largest number of corners of a hull. With more, finding the farthest corner costs as much as a
// walk through the triangles.
constexpr std::size_t kMaxCorners = 2048;
// chosen: additional shrinking of the inner hull, as a share of the extent. With it, meshes whose
// inner hulls overlap also overlap by their triangles, whatever the rounding.
constexpr double kFurtherShrinking = 1e-6;
// chosen: smallest scale of an inner hull. A smaller one decides no faster than a walk through the
// tree.
constexpr double kMinScale = 0.5;
// derived: some thousands of roundings, so that no triangle is in the interior of the depth hull.
constexpr double kDepthShrinking = 1e-12;

// The vertices that triangles use.
std::vector<Vector3> CornersOf(const TriangleMesh& mesh) {
  std::vector<bool> is_used(mesh.vertices.size());
  for (const TriangleMesh::Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) is_used[corner] = true;
  }
  std::vector<Vector3> corners;
  for (std::size_t k = 0; k < is_used.size(); ++k) {
    if (is_used[k]) corners.push_back(mesh.vertices[k]);
  }
  return corners;
}

// True if the ball meets the capsule around a closed hole, so that it may lie outside of the true
// solid.
bool MeetsCap(const InnerSphere& ball, const std::vector<MeshCap>& caps) {
  return std::ranges::any_of(caps, [&](const MeshCap& cap) {
    const Vector3 along = cap.axis[1] - cap.axis[0];
    const double share =
        std::clamp((ball.centre - cap.axis[0]).dot(along) / along.squaredNorm(), 0.0, 1.0);
    const double distance_m = (ball.centre - cap.axis[0] - share * along).norm();
    return distance_m <= ball.radius_m + cap.radius_m;
  });
}

}  // namespace

HullCore::HullCore(std::vector<Vector3> vertices)
    : vertices_(std::move(vertices)),
      lanes_(vertices_),
      core_(CoreOf(std::span<const Vector3>(vertices_))) {
  if (vertices_.size() < VertexLanes::kMin) return;
  std::get<VertexCore>(core_.core).lanes = &lanes_;
}

std::unique_ptr<const MeshHulls> MeshHulls::Make(const Mesh& mesh, const TriangleTree& tree,
                                                 WorkCounter* work) {
  if (mesh.mesh->vertices.size() > kMaxVertices) return nullptr;
  const TriangleMesh hull = ConvexHull3(CornersOf(*mesh.mesh), work);
  if (hull.triangles.empty() || hull.vertices.size() > kMaxCorners) return nullptr;
  std::unique_ptr<MeshHulls> hulls(new MeshHulls(hull.vertices));
  if (!mesh.watertight) return hulls;
  hulls->inner_spheres_ =
      FindInnerSpheres(tree, kFurtherShrinking * hulls->outer_hull().extent_m, work);
  if (mesh.caps != nullptr) {
    std::erase_if(hulls->inner_spheres_,
                  [&](const InnerSphere& ball) { return MeetsCap(ball, *mesh.caps); });
  }
  const Vector3& centre = hulls->outer_hull().centre;
  const std::vector<Vector3> polar = PolarOf(hull, centre);
  if (polar.empty()) return hulls;
  std::vector<double> scales = PlaneScales(polar, centre, tree, kMinScale, work);
  const double scale = *std::ranges::min_element(scales) - kFurtherShrinking;
  if (scale < kMinScale || !tree.Contains(centre, work)) return hulls;
  std::vector<Vector3> corners = hull.vertices;
  for (Vector3& corner : corners) corner = centre + scale * (corner - centre);
  hulls->inner_hull_.emplace(std::move(corners));
  hulls->hull_gap_m_ = (1 - scale) * hulls->outer_hull().extent_m;
  for (double& of_plane : scales) of_plane -= kDepthShrinking;
  std::vector<Vector3> behind = CornersBehind(polar, scales, centre, work);
  if (!behind.empty()) hulls->depth_hull_.emplace(std::move(behind));
  return hulls;
}

namespace {

// Decides by the inner hulls: true if they overlap, false if the gap between them exceeds the
// thickness of the walls around them, else empty.
std::optional<bool> InnerHullsOverlap(const ConvexCore* within_a, const ConvexCore* within_b,
                                      double hull_gaps_m, const Pose& X_AB) {
  if (within_a == nullptr || within_b == nullptr) return std::nullopt;
  const double radii_m = within_b->radius_m;
  return GjkOverlap(CoreDifference(*within_a, *within_b, X_AB), {radii_m, radii_m + hull_gaps_m});
}

std::optional<bool> FalseIfSeparated(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB) {
  const std::optional<bool> result = GjkOverlap(CoreDifference(a, b, X_AB), b.radius_m);
  return result == false ? result : std::nullopt;
}

}  // namespace

std::optional<bool> HullsOverlap(const MeshHulls& a, const ConvexCore& b, const Pose& X_AB) {
  if (const auto result = InnerHullsOverlap(a.inner_hull(), &b, a.hull_gap_m(), X_AB))
    return result;
  return FalseIfSeparated(a.outer_hull(), b, X_AB);
}

std::optional<bool> HullsOverlap(const MeshHulls& a, const MeshHulls& b, const Pose& X_AB) {
  const double hull_gaps_m = a.hull_gap_m() + b.hull_gap_m();
  if (const auto result = InnerHullsOverlap(a.inner_hull(), b.inner_hull(), hull_gaps_m, X_AB))
    return result;
  return FalseIfSeparated(a.outer_hull(), b.outer_hull(), X_AB);
}

std::optional<bool> QuickOverlap(const CentredMesh& a, const ConvexCore& b, const Pose& X_AB,
                                 const Pose& X_BA) {
  const PieceDistance distance_m(b);
  if (!distance_m.IsExact()) return std::nullopt;
  const ConvexCore& around = a.hulls.outer_hull();
  const Vector3 nearest_B = ClampToCore(b, a.centre_B);
  const Vector3 way_B = nearest_B - a.centre_B;
  const double extent_m = around.extent_m + b.extent_m, way_m = way_B.norm();
  const double rounding_m = kTouchingRatio * extent_m;
  if (way_m > rounding_m) {
    const Vector3 foremost_B = X_BA * SupportPoint(around, X_AB.linear() * way_B);
    const double gap_m = (nearest_B - foremost_B).dot(way_B) / way_m;
    if (gap_m > b.radius_m + rounding_m) return false;
    if (distance_m(foremost_B) < -kFurtherShrinking * extent_m) return true;
  }
  for (const InnerSphere& ball : a.hulls.inner_spheres()) {
    if (distance_m(X_BA * ball.centre) < ball.radius_m) return true;
  }
  return std::nullopt;
}

namespace {

// True if B lies beyond a face of A's box. Tests the axis of that box along which the boxes are
// farthest apart.
bool FaceOfFirstSeparates(const BoxedMesh& a, const BoxedMesh& b, const Pose& X_AB,
                          double rounding_m) {
  const Vector3 between = X_AB * b.bounds.center() - a.bounds.center();
  const Vector3 off = between.cwiseAbs() - 0.5 * a.bounds.sizes() -
                      0.5 * (X_AB.linear().cwiseAbs() * b.bounds.sizes());
  int axis = 0;
  if (off.maxCoeff(&axis) > rounding_m) return true;
  const double side = between[axis] < 0 ? -1 : 1;
  const Vector3 back_B = -side * X_AB.linear().row(axis).transpose();
  const Vector3 foremost = X_AB * SupportPoint(b.hulls.outer_hull(), back_B);
  const double face = side < 0 ? -a.bounds.min()[axis] : a.bounds.max()[axis];
  return side * foremost[axis] - face > rounding_m;
}

}  // namespace

bool BoxFaceSeparates(const BoxedMesh& a, const BoxedMesh& b, const Pose& X_AB) {
  const double extents_m = a.hulls.outer_hull().extent_m + b.hulls.outer_hull().extent_m;
  const double rounding_m = kTouchingRatio * extents_m;
  return FaceOfFirstSeparates(a, b, X_AB, rounding_m) ||
         FaceOfFirstSeparates(b, a, X_AB.inverse(Eigen::Isometry), rounding_m);
}

}  // namespace cwm::collision
