#include "collision/kernels/compound_pair.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "collision/kernels/closed_forms.h"
#include "collision/kernels/convex_pair.h"
#include "collision/kernels/gjk.h"

namespace cwm::collision {
namespace {

struct Enclosure {
  const ConvexCore& core;
  Pose X_SE;
};

Enclosure EnclosureOf(const ExactGeometry& geometry) {
  if (IsConvex(geometry.kind())) return {geometry.pieces().front(), Pose::Identity()};
  return {geometry.enclosure(), geometry.X_SE()};
}

// The outer hull of a mesh that has one, else EnclosureOf.
Enclosure TightestAround(const ExactGeometry& geometry) {
  const MeshHulls* const hulls = geometry.hulls();
  if (hulls != nullptr) return {hulls->outer_hull(), Pose::Identity()};
  return EnclosureOf(geometry);
}

// A convex solid within the geometry, in its frame; nullptr if none is known.
const ConvexCore* WithinOf(const ExactGeometry& geometry) {
  if (IsConvex(geometry.kind())) return &geometry.pieces().front();
  const MeshHulls* const hulls = geometry.hulls();
  return hulls != nullptr ? hulls->depth_hull() : nullptr;
}

}  // namespace

PairDistance WithDepthBound(const PairDistance& deepest_part, const ExactGeometry& a,
                            const ExactGeometry& b, const Pose& X_AB) {
  PairDistance answer = deepest_part;
  const ConvexCore* const within_a = WithinOf(a);
  const ConvexCore* const within_b = WithinOf(b);
  if (within_a != nullptr && within_b != nullptr) {
    const PairDistance within = ConvexDistance(*within_a, *within_b, X_AB);
    if (within.distance_m < answer.distance_m) answer = within;
  }
  const Enclosure around_a = TightestAround(a), around_b = TightestAround(b);
  const Pose X_EaEb = around_a.X_SE.inverse() * X_AB * around_b.X_SE;
  const PairDistance around = ConvexDistance(around_a.core, around_b.core, X_EaEb);
  answer.bound_m += std::max(answer.distance_m - around.distance_m, 0.0) + around.bound_m;
  answer.accuracy = answer.bound_m <= kExactTolerance_m ? Accuracy::kExact : Accuracy::kBounded;
  if (answer.accuracy == Accuracy::kExact) answer.bound_m = 0;
  if (a.IsOpen() || b.IsOpen()) answer.accuracy = Accuracy::kSurfaceOnly;
  return answer;
}

std::optional<double> LowerBoundByEnclosures_m(const ExactGeometry& a, const ExactGeometry& b,
                                               const Pose& X_AB) {
  const Enclosure around_a = TightestAround(a), around_b = TightestAround(b);
  const CoreDifference difference(around_a.core, around_b.core,
                                  around_a.X_SE.inverse() * X_AB * around_b.X_SE);
  const GjkResult result = GjkDistance(difference);
  if (result.outcome != GjkOutcome::kSeparated) return std::nullopt;
  const double radii_m = around_a.core.radius_m + around_b.core.radius_m;
  // Hulls contain their meshes up to roundings of the extent.
  const double rounding_m = kTouchingRatio * (around_a.core.extent_m + around_b.core.extent_m);
  const double bound_m = result.distance_m - result.bound_m - radii_m - rounding_m;
  return bound_m > 0 ? std::optional(bound_m) : std::nullopt;
}

namespace {

// The lowest corner of a mesh in the frame of a half-space; empty if it is higher than
// `max_height_m`. Most boxes of the tree are skipped, since they lie above the lowest corner found
// so far. The first corner below `enough_m` ends the search.
struct HeightLimits {
  double max_height_m, enough_m;
};
std::optional<Vector3> LowestCorner(const TriangleTree& tree, const Pose& X_AB,
                                    const HeightLimits& limits, WorkCounter* work) {
  const Vector3 up_B = X_AB.linear().row(2).transpose();
  const Vector3 reach_B = up_B.cwiseAbs();
  const auto lower_bound_m = [&](std::int32_t node) {
    const Aabb& box = tree.nodes()[static_cast<std::size_t>(node)].bounds;
    return X_AB.translation().z() + up_B.dot(box.center()) - 0.5 * reach_B.dot(box.sizes());
  };
  // Rounding error of the bounds: a few roundings of the largest number in them.
  const double largest_m =
      X_AB.translation().norm() + tree.bounds().min().norm() + tree.bounds().max().norm();
  const double rounding_m = 8 * std::numeric_limits<double>::epsilon() * largest_m;
  std::optional<Vector3> lowest;
  double limit_m = limits.max_height_m;
  struct Entry {
    std::int32_t node;
    double bound_m;
  };
  std::array<Entry, kTreeStackSize> stack;
  std::size_t size = 0;
  stack[size++] = {0, lower_bound_m(0)};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (MustEnd(work, 1)) return lowest;
    if (entry.bound_m - rounding_m > limit_m) continue;
    const TriangleTree::Node& node = tree.nodes()[static_cast<std::size_t>(entry.node)];
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      for (const Vector3& corner : tree.triangle(i).corners) {
        const Vector3 p = X_AB * corner;
        if (p.z() > limit_m || (lowest && p.z() == limit_m)) continue;
        lowest = p;
        limit_m = p.z();
      }
    }
    if (lowest && limit_m < limits.enough_m) return lowest;
    if (node.count > 0) continue;
    Entry left{entry.node + 1, lower_bound_m(entry.node + 1)};
    Entry right{node.right, lower_bound_m(node.right)};
    if (left.bound_m < right.bound_m) std::swap(left, right);
    stack[size++] = left;  // the lower one is popped first
    stack[size++] = right;
  }
  return lowest;
}

PairDistance LowestPiece(const ExactGeometry& b, const Pose& X_AB) {
  PairDistance lowest{.distance_m = std::numeric_limits<double>::infinity()};
  for (const ConvexCore& piece : b.pieces()) {
    const PairDistance answer = HalfSpaceToConvex(piece, X_AB);
    if (answer.distance_m < lowest.distance_m) lowest = answer;
  }
  return lowest;
}

}  // namespace

PairDistance HalfSpaceToAny(const ExactGeometry& b, const Pose& X_AB, const SearchLimits& limits) {
  if (b.tree() == nullptr) return LowestPiece(b, X_AB);
  constexpr double kNone_m = -std::numeric_limits<double>::infinity();
  const std::optional<Vector3> lowest =
      LowestCorner(*b.tree(), X_AB, {limits.max_distance_m, kNone_m}, limits.work);
  if (!lowest) return FartherThan(limits.max_distance_m);
  PairDistance answer{lowest->z(), Vector3(lowest->x(), lowest->y(), 0), *lowest, Vector3::UnitZ()};
  if (b.IsOpen()) answer.accuracy = Accuracy::kSurfaceOnly;
  return answer;
}

bool HalfSpaceOverlapsAny(const ExactGeometry& b, const Pose& X_AB, WorkCounter* work) {
  if (b.tree() == nullptr) return LowestPiece(b, X_AB).distance_m < 0;
  const std::optional<Vector3> lowest = LowestCorner(*b.tree(), X_AB, {0, 0}, work);
  return lowest && lowest->z() < 0;
}

namespace {

struct PiecePair {
  std::size_t a = 0, b = 0;
};

// The pair of pieces whose bounds are nearest to each other. Its distance rules out most other
// pairs.
PiecePair LikelyNearest(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                        WorkCounter* work) {
  PiecePair nearest;
  double min_gap = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < b.pieces().size(); ++j) {
    if (MustEnd(work, a.pieces().size())) break;
    const Aabb bounds_b = b.piece_bounds()[j].transformed(X_AB);
    for (std::size_t i = 0; i < a.pieces().size(); ++i) {
      const double gap = BoxDistance_m(a.piece_bounds()[i], bounds_b);
      if (gap >= min_gap) continue;
      min_gap = gap;
      nearest = {i, j};
    }
  }
  return nearest;
}

}  // namespace

PairDistance PiecesToPieces(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                            const SearchLimits& limits) {
  const double max_distance_m = limits.max_distance_m;
  const PiecePair first = LikelyNearest(a, b, X_AB, limits.work);
  PairDistance best =
      ConvexDistance(a.pieces()[first.a], b.pieces()[first.b], X_AB, std::max(max_distance_m, 0.0));
  for (std::size_t j = 0; j < b.pieces().size(); ++j) {
    if (MustEnd(limits.work, a.pieces().size())) return best;
    const Aabb bounds_b = b.piece_bounds()[j].transformed(X_AB);
    for (std::size_t i = 0; i < a.pieces().size(); ++i) {
      const double limit = std::min(best.distance_m, max_distance_m);
      if (i == first.a && j == first.b) continue;
      if (BoxDistance_m(a.piece_bounds()[i], bounds_b) > std::max(limit, 0.0)) continue;
      if (MustEnd(limits.work, kStepsPerConvexPair)) return best;
      const PairDistance answer =
          ConvexDistance(a.pieces()[i], b.pieces()[j], X_AB, std::max(limit, 0.0));
      if (answer.distance_m < best.distance_m) best = answer;
    }
  }
  if (best.distance_m > max_distance_m) return FartherThan(max_distance_m);
  return best.distance_m < 0 ? WithDepthBound(best, a, b, X_AB) : best;
}

bool PiecesOverlap(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                   WorkCounter* work) {
  if (a.pieces().size() == 1 && b.pieces().size() == 1) {
    return ConvexOverlap(a.pieces().front(), b.pieces().front(), X_AB);
  }
  for (std::size_t j = 0; j < b.pieces().size(); ++j) {
    if (MustEnd(work, a.pieces().size())) return false;
    const Aabb bounds_b = b.piece_bounds()[j].transformed(X_AB);
    for (std::size_t i = 0; i < a.pieces().size(); ++i) {
      if (BoxDistance_m(a.piece_bounds()[i], bounds_b) > 0) continue;
      if (MustEnd(work, kStepsPerConvexPair)) return false;
      if (ConvexOverlap(a.pieces()[i], b.pieces()[j], X_AB)) return true;
    }
  }
  return false;
}

}  // namespace cwm::collision
