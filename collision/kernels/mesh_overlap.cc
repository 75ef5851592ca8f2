// Overlap tests for meshes: by their hulls, and if these cannot decide, by trees of balls and
// single triangles. A ball around a node against the exact distance of the other solid prunes more
// than two boxes do, above all for the walls and boards of a scene.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "collision/kernels/closed_forms.h"
#include "collision/kernels/compound_pair.h"
#include "collision/kernels/convex_pair.h"
#include "collision/kernels/flush_overlap.h"
#include "collision/kernels/piece_distance.h"
#include "collision/kernels/triangle_overlap.h"

namespace cwm::collision {
namespace {

bool TriangleOverlapsPiece(const TriangleCorners& triangle, const ConvexCore& piece,
                           const Pose& X_AB, const Pose& X_BA) {
  if (const auto* box = std::get_if<Box>(&piece.core); box != nullptr && piece.radius_m == 0) {
    const auto& c = triangle.corners;
    const Overlap result = TriangleOverlapsBox({X_BA * c[0], X_BA * c[1], X_BA * c[2]}, *box);
    if (result != Overlap::kUnsure) return result == Overlap::kYes;
  }
  return ConvexOverlap(CoreOf(std::span<const Vector3>(triangle.corners)), piece, X_AB);
}

bool SurfaceOverlapsPiece(const TriangleTree& tree, const ConvexCore& piece, const Pose& X_AB,
                          WorkCounter* work) {
  const Pose X_BA = X_AB.inverse(Eigen::Isometry);
  const PieceDistance distance_m(piece);
  std::array<std::int32_t, kTreeStackSize> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::int32_t index = stack[--size];
    const TriangleTree::Node& node = tree.nodes()[static_cast<std::size_t>(index)];
    if (MustEnd(work, node.count > 0 ? kStepsPerConvexPair : 1)) return false;
    const double off_m = distance_m(X_BA * node.bounds.center());
    if (off_m > node.radius_m) continue;
    if (off_m < -node.radius_m) return true;  // the whole node lies inside
    if (node.count == 0) {
      stack[size++] = node.right;
      stack[size++] = index + 1;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      if (TriangleOverlapsPiece(tree.triangle(i), piece, X_AB, X_BA)) return true;
    }
  }
  return false;
}

// Searches for triangles of two meshes that cross, and collects those that touch.
class CrossingSearch {
 public:
  CrossingSearch(const TriangleTree& a, const TriangleTree& b, const Pose& X_AB, WorkCounter* work)
      : a_(a),
        b_(b),
        X_AB_(X_AB),
        reach_AB_(X_AB.linear().cwiseAbs()),
        touching_depth_m_(TouchingDepth_m(a, b, X_AB)),
        work_(work) {}

  // True if triangles cross. Ends at the first pair that does.
  bool Run() { return Closeness(0, 0) && Visit(0, 0); }
  // The first pairs that touch, as many as Cross keeps. Visits all pairs: those that cross do not
  // end the search, since rounding may have made a touching pair cross.
  const std::vector<TouchingTriangles>& CollectTouching() {
    ends_where_crossing_ = false;
    Run();
    return touching_;
  }
  const std::vector<TouchingTriangles>& touching() const { return touching_; }

 private:
  const TriangleTree::Node& NodeA(std::int32_t i) const {
    return a_.nodes()[static_cast<std::size_t>(i)];
  }
  const TriangleTree::Node& NodeB(std::int32_t i) const {
    return b_.nodes()[static_cast<std::size_t>(i)];
  }

  // The squared distance between the centres of two nodes, relative to the squared sum of their
  // radii; empty if balls or boxes prove that the nodes are apart.
  std::optional<double> Closeness(std::int32_t i, std::int32_t j) const {
    const TriangleTree::Node &a = NodeA(i), &b = NodeB(j);
    const Vector3 between = X_AB_ * b.bounds.center() - a.bounds.center();
    const double radii = a.radius_m + b.radius_m;
    const double squared_m2 = between.squaredNorm();
    if (squared_m2 > radii * radii) return std::nullopt;
    const Vector3 half_a = 0.5 * a.bounds.sizes(), half_b = 0.5 * b.bounds.sizes();
    if ((between.cwiseAbs() - half_a - reach_AB_ * half_b).maxCoeff() > 0) return std::nullopt;
    const Vector3 between_B = X_AB_.linear().transpose() * between;
    if ((between_B.cwiseAbs() - half_b - reach_AB_.transpose() * half_a).maxCoeff() > 0) {
      return std::nullopt;
    }
    return squared_m2 / (radii * radii);
  }

  // Opens the larger of two nodes that may overlap and visits the child that is closer first.
  bool Visit(std::int32_t i, std::int32_t j) {
    const TriangleTree::Node &a = NodeA(i), &b = NodeB(j);
    if (MustEnd(work_, 2)) return true;  // the cost of two pairs of nodes, or of some triangles
    if (a.count > 0 && b.count > 0) return AnyTrianglesCross(a, b);
    const bool open_a = b.count > 0 || (a.count == 0 && a.radius_m >= b.radius_m);
    const std::array<std::int32_t, 2> left = {open_a ? i + 1 : i, open_a ? j : j + 1};
    const std::array<std::int32_t, 2> right = {open_a ? a.right : i, open_a ? j : b.right};
    const std::optional<double> of_left = Closeness(left[0], left[1]);
    const std::optional<double> of_right = Closeness(right[0], right[1]);
    const bool left_first = of_left && (!of_right || *of_left <= *of_right);
    if (left_first && Visit(left[0], left[1])) return true;
    if (of_right && Visit(right[0], right[1])) return true;
    return of_left && !left_first && Visit(left[0], left[1]);
  }

  bool AnyTrianglesCross(const TriangleTree::Node& a, const TriangleTree::Node& b) {
    for (std::int32_t j = b.first; j < b.first + b.count; ++j) {
      const TriangleCorners& own = b_.triangle(j);
      const TrianglePoints other = {X_AB_ * own.corners[0], X_AB_ * own.corners[1],
                                    X_AB_ * own.corners[2]};
      for (std::int32_t i = a.first; i < a.first + a.count; ++i) {
        if (Cross(a_.triangle(i), own, other) && ends_where_crossing_) return true;
      }
    }
    return false;
  }

  // True if the triangles cross; touching pairs are collected. `b_in_A` are the corners of `b` in
  // the frame of A.
  bool Cross(const TriangleCorners& a, const TriangleCorners& b, const TrianglePoints& b_in_A) {
    const Overlap result = TrianglesOverlap(a.corners, b_in_A);
    if (result != Overlap::kUnsure) return result == Overlap::kYes;
    constexpr std::size_t kMaxTouching = 4096;
    if (touching_.size() < kMaxTouching) touching_.push_back({a.corners, b_in_A});
    // The same test as in MeshToMesh, so that both agree.
    return IterativeConvexDistance(CoreOf(std::span<const Vector3>(a.corners)),
                                   CoreOf(std::span<const Vector3>(b.corners)), X_AB_, 0)
               .distance_m < -touching_depth_m_;
  }

  const TriangleTree& a_;
  const TriangleTree& b_;
  const Pose& X_AB_;
  const Matrix3 reach_AB_;
  const double touching_depth_m_;
  WorkCounter* const work_;
  bool ends_where_crossing_ = true;
  std::vector<TouchingTriangles> touching_;
};

// True if a component of B lies inside A. A point on the surface of A does not count as inside.
bool ContainsComponent(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                       WorkCounter* work) {
  if (a.IsOpen()) return false;
  const double touching_depth_m = TouchingDepth_m(*a.tree(), *b.tree(), X_AB);
  const std::vector<Vector3>& points_B = b.tree()->component_points();
  return std::any_of(points_B.begin(), points_B.end(), [&](const Vector3& p_B) {
    if (MustEnd(work, kStepsPerContainmentTest)) return true;
    const Vector3 p = X_AB * p_B;
    return a.tree()->Contains(p, work) &&
           a.tree()->NearestPoint(p, touching_depth_m, work).distance_m >= touching_depth_m;
  });
}

double RadiusOf(const TriangleTree& tree) { return tree.nodes().front().radius_m; }

bool MeshOverlapsPiece(const ExactGeometry& a, const ConvexCore& piece, const Pose& X_AB,
                       WorkCounter* work) {
  const TriangleTree& tree = *a.tree();
  const Pose X_BA = X_AB.inverse(Eigen::Isometry);
  const Vector3 centre_B = X_BA * tree.bounds().center();
  if (PieceDistance(piece)(centre_B) > RadiusOf(tree)) return false;
  if (const MeshHulls* hulls = a.hulls(work); hulls != nullptr) {
    const CentredMesh mesh{.hulls = *hulls, .centre_B = centre_B};
    if (const auto result = QuickOverlap(mesh, piece, X_AB, X_BA)) return *result;
    if (const auto result = HullsOverlap(*hulls, piece, X_AB)) return *result;
  }
  return SurfaceOverlapsPiece(tree, piece, X_AB, work) ||
         (!a.IsOpen() && tree.Contains(X_AB * piece.centre, work));
}

bool BoundingSpheresOverlap(const TriangleTree& a, const TriangleTree& b, const Pose& X_AB) {
  const Vector3 between = X_AB * b.bounds().center() - a.bounds().center();
  const double radii_m = RadiusOf(a) + RadiusOf(b);
  return between.squaredNorm() <= radii_m * radii_m;
}

}  // namespace

bool MeshOverlapsPieces(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                        WorkCounter* work) {
  if (std::holds_alternative<Sphere>(b.shape())) {
    return MeshToPieces(a, b, X_AB, {0, work}).distance_m < 0;
  }
  return std::any_of(b.pieces().begin(), b.pieces().end(), [&](const ConvexCore& piece) {
    return MustEnd(work, kStepsPerConvexPair) || MeshOverlapsPiece(a, piece, X_AB, work);
  });
}

bool MeshesOverlap(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                   WorkCounter* work) {
  if (!BoundingSpheresOverlap(*a.tree(), *b.tree(), X_AB)) return false;
  if (a.hulls(work) != nullptr && b.hulls(work) != nullptr) {
    const MeshHulls &of_a = *a.hulls(), &of_b = *b.hulls();
    if (BoxFaceSeparates({of_a, a.tree()->bounds()}, {of_b, b.tree()->bounds()}, X_AB))
      return false;
    if (const auto result = HullsOverlap(of_a, of_b, X_AB)) return *result;
    if (SpheresOverlap(of_a.inner_spheres(), of_b.inner_spheres(), X_AB)) return true;
  }
  CrossingSearch search(*a.tree(), *b.tree(), X_AB, work);
  if (search.Run() || ContainsComponent(a, b, X_AB, work) ||
      ContainsComponent(b, a, X_AB.inverse(Eigen::Isometry), work)) {
    return true;
  }
  if (a.IsOpen() || b.IsOpen()) return false;
  return FindPointInBoth({*a.tree(), *b.tree(), X_AB}, search.touching(), work).has_value();
}

std::optional<Vector3> PointInTouchingMeshes(const ExactGeometry& a, const ExactGeometry& b,
                                             const Pose& X_AB, WorkCounter* work) {
  if (a.IsOpen() || b.IsOpen()) return std::nullopt;
  CrossingSearch search(*a.tree(), *b.tree(), X_AB, work);
  return FindPointInBoth({*a.tree(), *b.tree(), X_AB}, search.CollectTouching(), work);
}

}  // namespace cwm::collision
