#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "collision/geometry/triangle.h"
#include "collision/kernels/closed_forms.h"
#include "collision/kernels/compound_pair.h"
#include "collision/kernels/convex_pair.h"
#include "collision/kernels/flush_overlap.h"
#include "collision/kernels/gjk.h"
#include "collision/kernels/piece_distance.h"

namespace cwm::collision {
namespace {

// chosen: overlapping pairs of triangles whose depth is measured. The depth is only a bound in any
// case, and a mesh deep in another one has as many such pairs as triangles.
constexpr int kMaxDepths = 64;

// The best answer so far of a search that first looks for the nearest triangle and, once one
// overlaps, for the deepest.
class Best {
 public:
  explicit Best(double max_distance_m, double slack = 1)
      : max_distance_m_(max_distance_m), slack_(slack) {}

  void Offer(const PairDistance& answer) {
    if (answer.distance_m < answer_.distance_m) answer_ = answer;
    if (answer.distance_m < 0) ++overlaps_;
  }

  // The distance below which further pairs still matter; negative if only overlaps do.
  double limit_m() const {
    const double found_m = answer_.distance_m;
    return std::min(found_m > 0 ? found_m / slack_ : found_m, max_distance_m_);
  }
  bool IsDone() const { return overlaps_ >= kMaxDepths; }
  const PairDistance& answer() const { return answer_; }
  bool IsOverlapping() const { return answer_.distance_m < 0; }

 private:
  const double max_distance_m_, slack_;
  int overlaps_ = 0;
  PairDistance answer_{.distance_m = std::numeric_limits<double>::infinity()};
};

// The range of a search for the nearest triangles: the limit or the distance of the inner hulls,
// which is at least that of the meshes. Empty if the outer hulls are farther apart than the limit.
std::optional<double> Reach_m(const MeshHulls& a, const MeshHulls& b, const Pose& X_AB,
                              double max_distance_m) {
  const double rounding_m = kTouchingRatio * (a.outer_hull().extent_m + b.outer_hull().extent_m);
  const CoreDifference around(a.outer_hull(), b.outer_hull(), X_AB);
  const double limit_m = std::max(max_distance_m, 0.0) + rounding_m;
  if (GjkDistance(around, limit_m).outcome == GjkOutcome::kBeyond) return std::nullopt;
  if (a.inner_hull() == nullptr || b.inner_hull() == nullptr) return max_distance_m;
  const GjkResult within = GjkDistance(CoreDifference(*a.inner_hull(), *b.inner_hull(), X_AB));
  if (within.outcome != GjkOutcome::kSeparated) return max_distance_m;
  return std::min(max_distance_m, within.distance_m + rounding_m);
}

// The distance of a triangle (A) and a convex solid, in the frame of the mesh.
PairDistance TriangleToConvex(const TriangleCorners& triangle, const ConvexCore& b,
                              const Pose& X_AB, double limit_m) {
  const ConvexCore core = CoreOf(std::span<const Vector3>(triangle.corners));
  return IterativeConvexDistance(core, b, X_AB, std::max(limit_m, 0.0));
}

// The steps of testing one triangle against the piece, which takes some four support points of it.
std::size_t StepsOf(const ConvexCore& piece) {
  const auto* hull = std::get_if<VertexCore>(&piece.core);
  return kStepsPerConvexPair + (hull != nullptr ? hull->vertices.size() : 0);
}

using CornerPoints = std::array<Vector3, 3>;

Vector3 MiddleOf(const CornerPoints& c) { return (c[0] + c[1] + c[2]) / 3.0; }

double RadiusAbout(const Vector3& middle, const CornerPoints& c) {
  return std::sqrt(std::max({(c[0] - middle).squaredNorm(), (c[1] - middle).squaredNorm(),
                             (c[2] - middle).squaredNorm()}));
}

// The separation of two triangles along a direction; for a unit direction a lower bound of their
// distance.
double Separation(const CornerPoints& a, const CornerPoints& b, const Vector3& d) {
  return std::min({d.dot(b[0]), d.dot(b[1]), d.dot(b[2])}) -
         std::max({d.dot(a[0]), d.dot(a[1]), d.dot(a[2])});
}

// True if the projections onto the line between their middles prove that two triangles are farther
// apart than a limit.
bool AreFartherThan(double limit_m, const CornerPoints& a, const CornerPoints& b) {
  const Vector3 between = MiddleOf(b) - MiddleOf(a);
  const double separation = Separation(a, b, between);
  const double limit = std::max(limit_m, 0.0);
  return separation > 0 && separation * separation > limit * limit * between.squaredNorm();
}

Aabb BoundsIn(const Aabb& bounds_B, const Pose& X_AB) { return bounds_B.transformed(X_AB); }

// The distance of a mesh and a sphere, by the point of the mesh nearest to the centre. If they
// overlap, the centre must move at least as far as the depth says.
PairDistance MeshToSphere(const ExactGeometry& a, const Sphere& sphere, const Vector3& centre,
                          const SearchLimits& limits) {
  const double max_distance_m = limits.max_distance_m;
  const bool inside = !a.IsOpen() && a.tree()->Contains(centre, limits.work);
  const double reach =
      inside ? std::numeric_limits<double>::infinity() : max_distance_m + sphere.radius_m;
  const TriangleTree::Nearest nearest = a.tree()->NearestPoint(centre, reach, limits.work);
  if (!(nearest.distance_m < reach)) return FartherThan(max_distance_m);
  const Vector3 offset = centre - nearest.point;
  Vector3 normal = nearest.face_normal;
  if (nearest.distance_m > 0) normal = (inside ? -offset : offset) / nearest.distance_m;
  const double distance = inside ? -nearest.distance_m : nearest.distance_m;
  return {distance - sphere.radius_m, nearest.point, centre - sphere.radius_m * normal,
          normal.normalized()};
}

// The depth of a piece that lies inside the mesh without touching a triangle, by its centre, which
// must cross the surface.
PairDistance DepthInside(const ExactGeometry& a, const Vector3& centre, WorkCounter* work) {
  return MeshToSphere(a, Sphere{0}, centre, {.max_distance_m = 0, .work = work});
}

}  // namespace

PairDistance MeshToPieces(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                          const SearchLimits& limits) {
  const double max_distance_m = limits.max_distance_m;
  const TriangleTree& tree = *a.tree();
  if (const auto* sphere = std::get_if<Sphere>(&b.shape())) {
    PairDistance answer = MeshToSphere(a, *sphere, X_AB.translation(), limits);
    if (answer.distance_m < 0) return WithDepthBound(answer, a, b, X_AB);
    if (a.IsOpen()) answer.accuracy = Accuracy::kSurfaceOnly;
    return answer;
  }
  Best best(max_distance_m, limits.slack);
  const Pose X_BA = X_AB.inverse(Eigen::Isometry);
  for (std::size_t j = 0; j < b.pieces().size(); ++j) {
    const ConvexCore& piece = b.pieces()[j];
    const std::size_t steps = StepsOf(piece);
    const Vector3 centre = X_AB * piece.centre;
    const Aabb bounds_A = BoundsIn(b.piece_bounds()[j], X_AB);
    const PieceDistance distance_m(piece);
    // Bounded by a ball as well as by a box, since the box around an oblique piece is much larger
    // than the piece.
    const auto bound_m = [&](const TriangleTree::Node& node) {
      return std::max(BoxDistance_m(node.bounds, bounds_A),
                      distance_m(X_BA * node.bounds.center()) - node.radius_m);
    };
    tree.ForEachNearBy(
        bound_m, best.limit_m(),
        [&](const TriangleCorners& triangle, std::int32_t) {
          const Vector3 middle = MiddleOf(triangle.corners);
          const double off_m = distance_m(X_BA * middle) - RadiusAbout(middle, triangle.corners);
          std::size_t taken = 1;
          if (off_m <= std::max(best.limit_m(), 0.0)) {
            best.Offer(TriangleToConvex(triangle, piece, X_AB, best.limit_m()));
            taken = steps;
          }
          const bool must_end = MustEnd(limits.work, taken);
          return must_end || best.IsDone() ? TriangleTree::kEnd : best.limit_m();
        },
        limits.work);
    if (MustEnd(limits.work, 1)) return best.answer();
    if (!a.IsOpen() && tree.Contains(centre, limits.work))
      best.Offer(DepthInside(a, centre, limits.work));
  }
  PairDistance answer = best.answer();
  if (answer.distance_m > max_distance_m) return FartherThan(max_distance_m);
  if (answer.distance_m < 0) return WithDepthBound(answer, a, b, X_AB);
  if (a.IsOpen()) answer.accuracy = Accuracy::kSurfaceOnly;
  return answer;
}

namespace {

// Traverses two trees at once and opens the larger node. `offer` gets a triangle of A and one of B,
// as a core, and returns the maximum distance for the rest of the search, or kEnd to end it.
template <class Offer>
class DualSearch {
 public:
  DualSearch(const TriangleTree& a, const TriangleTree& b, const Pose& X_AB,
             const SearchLimits& limits, Offer offer)
      : a_(a),
        b_(b),
        X_AB_(X_AB),
        reach_AB_(X_AB.linear().cwiseAbs()),
        limit_m_(limits.max_distance_m),
        work_(limits.work),
        offer_(std::move(offer)) {}

  void Run() { Visit(0, 0, Gap(0, 0)); }

 private:
  const TriangleTree::Node& NodeA(std::int32_t i) const {
    return a_.nodes()[static_cast<std::size_t>(i)];
  }
  const TriangleTree::Node& NodeB(std::int32_t i) const {
    return b_.nodes()[static_cast<std::size_t>(i)];
  }
  // A lower bound of the distance between triangles of the two nodes, by their boxes along the axes
  // of both frames and by the balls around them.
  double Gap(std::int32_t i, std::int32_t j) const {
    const TriangleTree::Node &a = NodeA(i), &b = NodeB(j);
    const Vector3 between = X_AB_ * b.bounds.center() - a.bounds.center();
    const Vector3 between_B = X_AB_.linear().transpose() * between;
    const Vector3 half_a = 0.5 * a.bounds.sizes(), half_b = 0.5 * b.bounds.sizes();
    const double along_a =
        (between.cwiseAbs() - half_a - reach_AB_ * half_b).cwiseMax(0.0).squaredNorm();
    const double along_b = (between_B.cwiseAbs() - half_b - reach_AB_.transpose() * half_a)
                               .cwiseMax(0.0)
                               .squaredNorm();
    return std::max(std::sqrt(std::max(along_a, along_b)),
                    between.norm() - a.radius_m - b.radius_m);
  }

  Vector3 InB(const Vector3& p_A) const {
    return X_AB_.linear().transpose() * (p_A - X_AB_.translation());
  }
  // True if all triangles of a leaf are farther than `distance_m` from the point.
  static bool IsFartherThan(const TriangleTree& tree, const TriangleTree::Node& leaf,
                            const Vector3& point, double distance_m) {
    for (std::int32_t k = leaf.first; k < leaf.first + leaf.count; ++k) {
      const auto& [a, b, c] = tree.triangle(k).corners;
      if ((NearestOnTriangle(a, b, c, point) - point).squaredNorm() <= distance_m * distance_m) {
        return false;
      }
    }
    return true;
  }

  void Visit(std::int32_t i, std::int32_t j, double gap) {
    if (limit_m_ == TriangleTree::kEnd || gap > std::max(limit_m_, 0.0)) return;
    if (MustEnd(work_, 1)) limit_m_ = TriangleTree::kEnd;
    const TriangleTree::Node &a = NodeA(i), &b = NodeB(j);
    if (a.count > 0 && b.count > 0) return VisitLeaves(a, b);
    // A long triangle has a box and a ball much larger than itself.
    const double room_m = std::max(limit_m_, 0.0);
    if (b.count > 0 && IsFartherThan(b_, b, InB(a.bounds.center()), a.radius_m + room_m)) return;
    if (a.count > 0 && IsFartherThan(a_, a, X_AB_ * b.bounds.center(), b.radius_m + room_m)) return;
    const bool open_a =
        b.count > 0 || (a.count == 0 && a.bounds.sizes().norm() >= b.bounds.sizes().norm());
    const std::array<std::array<std::int32_t, 2>, 2> next = {
        std::array<std::int32_t, 2>{open_a ? i + 1 : i, open_a ? j : j + 1},
        std::array<std::int32_t, 2>{open_a ? a.right : i, open_a ? j : b.right}};
    const double first = Gap(next[0][0], next[0][1]), second = Gap(next[1][0], next[1][1]);
    const std::size_t near = second < first ? 1 : 0;
    Visit(next[near][0], next[near][1], std::min(first, second));
    Visit(next[1 - near][0], next[1 - near][1], std::max(first, second));
  }

  void VisitLeaves(const TriangleTree::Node& a, const TriangleTree::Node& b) {
    for (std::int32_t j = b.first; j < b.first + b.count; ++j) {
      const CornerPoints& own = b_.triangle(j).corners;
      const CornerPoints in_A = {X_AB_ * own[0], X_AB_ * own[1], X_AB_ * own[2]};
      const ConvexCore core = CoreOf(std::span<const Vector3>(own));
      for (std::int32_t i = a.first; i < a.first + a.count; ++i) {
        const bool is_far = AreFartherThan(limit_m_, a_.triangle(i).corners, in_A);
        if (!is_far) limit_m_ = offer_(a_.triangle(i), core);
        if (MustEnd(work_, is_far ? 1 : kStepsPerConvexPair)) limit_m_ = TriangleTree::kEnd;
        if (limit_m_ == TriangleTree::kEnd) return;
      }
    }
  }

  const TriangleTree& a_;
  const TriangleTree& b_;
  const Pose& X_AB_;
  const Matrix3 reach_AB_;
  double limit_m_;
  WorkCounter* const work_;
  Offer offer_;
};

// Offers the depths of the components of mesh B that lie inside the closed mesh A, in the frame of
// A.
void OfferEnclosedParts(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                        WorkCounter* work, Best& best) {
  const double touching_depth_m = TouchingDepth_m(*a.tree(), *b.tree(), X_AB);
  for (const Vector3& p_B : b.tree()->component_points()) {
    if (MustEnd(work, kStepsPerContainmentTest)) return;
    const Vector3 p = X_AB * p_B;
    if (!a.tree()->Contains(p, work)) continue;
    const PairDistance within = DepthInside(a, p, work);
    if (within.distance_m < -touching_depth_m) best.Offer(within);
  }
}

}  // namespace

namespace {

// Offers the depths of a point that lies in both meshes. To separate them, B must move at least as
// far as the point is deep in A, and as far as it is deep in B.
void OfferCommon(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                 WorkCounter* work, Best& best) {
  const std::optional<Vector3> p = PointInTouchingMeshes(a, b, X_AB, work);
  if (!p) return;
  best.Offer(DepthInside(a, *p, work));
  best.Offer(Swapped(InFrame(X_AB, DepthInside(b, X_AB.inverse() * *p, work))));
}

PairDistance TrianglesToTriangles(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                                  const SearchLimits& limits) {
  const double max_distance_m = limits.max_distance_m;
  Best best(max_distance_m, limits.slack);
  const double touching_depth_m = TouchingDepth_m(*a.tree(), *b.tree(), X_AB);
  DualSearch(*a.tree(), *b.tree(), X_AB, limits,
             [&](const TriangleCorners& triangle, const ConvexCore& core) {
               PairDistance result = TriangleToConvex(triangle, core, X_AB, best.limit_m());
               if (result.distance_m >= -touching_depth_m)
                 result.distance_m = std::max(result.distance_m, 0.0);
               best.Offer(result);
               return best.IsDone() ? TriangleTree::kEnd : best.limit_m();
             })
      .Run();
  // If surfaces do not cross, one point of each component decides whether it lies inside the other
  // mesh.
  if (!best.IsOverlapping() && !a.IsOpen()) OfferEnclosedParts(a, b, X_AB, limits.work, best);
  if (!best.IsOverlapping() && !b.IsOpen()) {
    Best swapped(max_distance_m);
    OfferEnclosedParts(b, a, X_AB.inverse(), limits.work, swapped);
    if (swapped.IsOverlapping()) best.Offer(Swapped(InFrame(X_AB, swapped.answer())));
  }
  const double size_m = a.tree()->nodes().front().radius_m + b.tree()->nodes().front().radius_m;
  if (!best.IsOverlapping() && best.answer().distance_m <= kTouchingRatio * size_m) {
    OfferCommon(a, b, X_AB, limits.work, best);
  }
  PairDistance answer = best.answer();
  if (answer.distance_m > max_distance_m) return FartherThan(max_distance_m);
  if (answer.distance_m < 0) return WithDepthBound(answer, a, b, X_AB);
  if (a.IsOpen() || b.IsOpen()) answer.accuracy = Accuracy::kSurfaceOnly;
  return answer;
}

}  // namespace

PairDistance MeshToMesh(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                        const SearchLimits& limits) {
  const double max_distance_m = limits.max_distance_m;
  if (a.hulls(limits.work) != nullptr && b.hulls(limits.work) != nullptr) {
    const std::optional<double> reach_m = Reach_m(*a.hulls(), *b.hulls(), X_AB, max_distance_m);
    if (!reach_m) return FartherThan(max_distance_m);
    if (*reach_m < max_distance_m) {
      const PairDistance answer =
          TrianglesToTriangles(a, b, X_AB, {*reach_m, limits.work, limits.slack});
      if (answer.distance_m <= *reach_m) return answer;
    }
  }
  return TrianglesToTriangles(a, b, X_AB, limits);
}

}  // namespace cwm::collision
