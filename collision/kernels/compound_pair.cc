#include "collision/kernels/compound_pair.h"

#include <algorithm>

#include "collision/kernels/closed_forms.h"
#include "collision/kernels/convex_pair.h"

namespace cwm::collision {
namespace {

// What kExact promises, see pair_answer.h.
constexpr double kExactTolerance_m = 1e-7;

struct Enclosure {
  const ConvexCore& core;
  Pose X_SE;
};

Enclosure EnclosureOf(const ExactGeometry& geometry) {
  if (IsConvex(geometry.kind())) return {geometry.pieces().front(), Pose::Identity()};
  return {geometry.enclosure(), geometry.X_SE()};
}

}  // namespace

PairDistance WithDepthBound(const PairDistance& deepest_part, const ExactGeometry& a,
                            const ExactGeometry& b, const Pose& X_AB) {
  PairDistance answer = deepest_part;
  const Enclosure around_a = EnclosureOf(a), around_b = EnclosureOf(b);
  const Pose X_EaEb = around_a.X_SE.inverse() * X_AB * around_b.X_SE;
  const PairDistance hulls = ConvexDistance(around_a.core, around_b.core, X_EaEb);
  answer.bound_m = std::max(answer.distance_m - hulls.distance_m, 0.0) + deepest_part.bound_m;
  answer.trust = answer.bound_m <= kExactTolerance_m ? Trust::kExact : Trust::kBounded;
  if (answer.trust == Trust::kExact) answer.bound_m = 0;
  if (a.IsOpen() || b.IsOpen()) answer.trust = Trust::kSurfaceOnly;
  return answer;
}

PairDistance HalfSpaceToAny(const ExactGeometry& b, const Pose& X_AB) {
  PairDistance lowest{.distance_m = std::numeric_limits<double>::infinity()};
  const auto consider = [&](const ConvexCore& part) {
    const PairDistance answer = HalfSpaceToConvex(part, X_AB);
    if (answer.distance_m < lowest.distance_m) lowest = answer;
  };
  for (const ConvexCore& piece : b.pieces()) consider(piece);
  if (b.tree() == nullptr) return lowest;
  for (const TriangleCorners& t : b.tree()->triangles()) {
    for (const Vector3& corner : t.corners) {
      const Vector3 p = X_AB * corner;
      if (p.z() >= lowest.distance_m) continue;
      lowest = {p.z(), Vector3(p.x(), p.y(), 0), p, Vector3::UnitZ()};
    }
  }
  if (b.IsOpen()) lowest.trust = Trust::kSurfaceOnly;
  return lowest;
}

namespace {

struct PiecePair {
  std::size_t a = 0, b = 0;
};

// The pair whose bounds are nearest to each other: its answer rules out most of the others.
PiecePair LikelyNearest(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB) {
  PiecePair nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < b.pieces().size(); ++j) {
    const Aabb bounds_b = b.piece_bounds()[j].transformed(X_AB);
    for (std::size_t i = 0; i < a.pieces().size(); ++i) {
      const double gap = BoxGap_m(a.piece_bounds()[i], bounds_b);
      if (gap >= least) continue;
      least = gap;
      nearest = {i, j};
    }
  }
  return nearest;
}

}  // namespace

PairDistance PiecesToPieces(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                            double max_distance_m) {
  const PiecePair first = LikelyNearest(a, b, X_AB);
  PairDistance best =
      ConvexDistance(a.pieces()[first.a], b.pieces()[first.b], X_AB, std::max(max_distance_m, 0.0));
  for (std::size_t j = 0; j < b.pieces().size(); ++j) {
    const Aabb bounds_b = b.piece_bounds()[j].transformed(X_AB);
    for (std::size_t i = 0; i < a.pieces().size(); ++i) {
      const double limit = std::min(best.distance_m, max_distance_m);
      if (i == first.a && j == first.b) continue;
      if (BoxGap_m(a.piece_bounds()[i], bounds_b) > std::max(limit, 0.0)) continue;
      const PairDistance answer =
          ConvexDistance(a.pieces()[i], b.pieces()[j], X_AB, std::max(limit, 0.0));
      if (answer.distance_m < best.distance_m) best = answer;
    }
  }
  if (best.distance_m > max_distance_m) return JustBeyond(max_distance_m);
  return best.distance_m < 0 ? WithDepthBound(best, a, b, X_AB) : best;
}

bool PiecesMeetPieces(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB) {
  if (a.pieces().size() == 1 && b.pieces().size() == 1) {
    return ConvexOverlap(a.pieces().front(), b.pieces().front(), X_AB);
  }
  for (std::size_t j = 0; j < b.pieces().size(); ++j) {
    const Aabb bounds_b = b.piece_bounds()[j].transformed(X_AB);
    for (std::size_t i = 0; i < a.pieces().size(); ++i) {
      if (BoxGap_m(a.piece_bounds()[i], bounds_b) > 0) continue;
      if (ConvexOverlap(a.pieces()[i], b.pieces()[j], X_AB)) return true;
    }
  }
  return false;
}

}  // namespace cwm::collision
