#include "collision/engines/bullet_engine.h"

#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "collision/engines/bullet_geometry.h"
#include "collision/engines/capability_table.h"
#include "collision/engines/piecewise.h"
#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {
namespace {

constexpr Capability N = Capability::kNothing;
constexpr Capability A = Capability::kAll;

constexpr CapabilityTable kTable = {{
    //                 sph box cyl con cap half pla cvx mesh
    /* sphere     */ {{A, A, A, A, A, A, A, A, A}},
    /* box        */ {{A, A, A, A, A, A, A, A, A}},
    /* cylinder   */ {{A, A, A, A, A, A, A, A, A}},
    /* cone       */ {{A, A, A, A, A, A, A, A, A}},
    /* capsule    */ {{A, A, A, A, A, A, A, A, A}},
    /* half-space */ {{A, A, A, A, A, N, A, A, N}},
    /* plate      */ {{A, A, A, A, A, A, A, A, A}},
    /* convex     */ {{A, A, A, A, A, A, A, A, A}},
    /* mesh       */ {{A, A, A, A, A, N, A, A, N}},
}};
static_assert(IsSymmetric(kTable));

// measured: Bullet's witness points lie within 1e-9 m of the surfaces, compared with the exact
// kernels. chosen: a thousand times that.
constexpr double kWitnessBound_m = 1e-6;

// Smaller gaps count as touching: the depth solver measures them, and its sign is not reliable.
constexpr double kTouching_m = 1e-9;

struct BulletForm final : EngineGeometry {
  explicit BulletForm(std::shared_ptr<const ExactGeometry> exact)
      : kind(exact->kind()), shape(MakeBulletShape(exact->shape())) {
    if (kind != ShapeKind::kHalfSpace) solid.emplace(std::move(exact));
  }
  ShapeKind kind;
  BulletShape shape;
  std::optional<Solid> solid;  // empty for half-spaces
};

const BulletForm& FormOf(const PlacedGeometry& placed) {
  return static_cast<const BulletForm&>(placed.geometry);
}

// The gap of the two shapes' extents along a unit direction from A to B. The signed distance is
// never less.
double ExtentGap_m(const btConvexShape& a, const btTransform& X_WA, const btConvexShape& b,
                   const btTransform& X_WB, const btVector3& direction) {
  const btVector3 in_a = X_WA.getBasis().transpose() * direction;
  const btVector3 in_b = X_WB.getBasis().transpose() * -direction;
  return (X_WB * b.localGetSupportingVertex(in_b) - X_WA * a.localGetSupportingVertex(in_a))
      .dot(direction);
}

// Empty if Bullet finds no answer, or one that its own normal refutes: without margins it reports a
// gap for some overlaps. The normal also bounds the error of a separated answer.
std::optional<PairDistance> BulletGjkDistance(const btConvexShape& a, const btTransform& X_WA,
                                              const btConvexShape& b, const btTransform& X_WB) {
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver depth;
  btGjkPairDetector detector(&a, &b, &simplex, &depth);
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA = X_WA;
  input.m_transformB = X_WB;
  btPointCollector found;
  detector.getClosestPoints(input, found, nullptr);
  if (!found.m_hasResult || !std::isfinite(found.m_distance)) return std::nullopt;
  const double length = found.m_normalOnBInWorld.length();
  if (!(std::abs(length - 1) < 1e-3)) return std::nullopt;  // a degenerate direction
  const btVector3 normal = found.m_normalOnBInWorld / -length;
  const double gap_m = ExtentGap_m(a, X_WA, b, X_WB, normal);
  if ((found.m_distance > kTouching_m) != (gap_m > 0)) return std::nullopt;
  PairDistance answer{.distance_m = found.m_distance,
                      .point_b = FromBullet(found.m_pointInWorld),
                      .normal = FromBullet(normal),
                      .solver = Solver::kEngine};
  answer.point_a = answer.point_b - answer.distance_m * answer.normal;
  answer.bound_m = std::max(0.0, answer.distance_m - gap_m) + kWitnessBound_m;
  answer.accuracy = answer.distance_m > kTouching_m ? Accuracy::kBounded : Accuracy::kDegraded;
  return answer;
}

// The kernels' answer, used when Bullet fails on a pair.
PairDistance WithoutBullet(const BulletForm& a, const Pose& X_WA, const BulletForm& b,
                           const Pose& X_WB) {
  return ExactDistance({a.solid->exact(), X_WA}, {b.solid->exact(), X_WB});
}

PairDistance ConvexDistance(const BulletForm& a, const Pose& X_WA, const BulletForm& b,
                            const Pose& X_WB) {
  bool failed = false;
  const std::size_t count_a = a.shape.pieces.size();
  const std::size_t count_b = b.shape.pieces.size();
  PairDistance answer = MinOverPieces(count_a, count_b, [&](std::size_t i, std::size_t j) {
    const BulletPiece& piece_a = a.shape.pieces[i];
    const BulletPiece& piece_b = b.shape.pieces[j];
    const auto piece = BulletGjkDistance(*piece_a.shape, ToBullet(X_WA * piece_a.X_SP),
                                         *piece_b.shape, ToBullet(X_WB * piece_b.X_SP));
    failed = failed || !piece.has_value();
    return piece.value_or(PairDistance{});
  });
  if (failed) return WithoutBullet(a, X_WA, b, X_WB);
  answer.bound_m += a.shape.bound_m + b.shape.bound_m;
  if (answer.distance_m < 0 && count_a * count_b > 1) {
    WidenToUnion(answer, OverlapBound(*a.solid, X_WA, *b.solid, X_WB));
  }
  return answer;
}

// A plane needs no search: the support point against it decides. Exact, up to the bound of the
// pieces.
PairDistance HalfSpaceDistance(const BulletForm& a, const Pose& X_WA, const Pose& X_WH) {
  const Vector3 normal_W = X_WH.linear().col(2);
  PairDistance answer = MinOverPieces(a.shape.pieces.size(), 1, [&](std::size_t i, std::size_t) {
    const BulletPiece& piece = a.shape.pieces[i];
    const Pose X_WP = X_WA * piece.X_SP;
    const Vector3 down_P = X_WP.linear().transpose() * -normal_W;
    PairDistance lowest{.solver = Solver::kEngine};
    lowest.point_a = X_WP * FromBullet(piece.shape->localGetSupportingVertex(ToBullet(down_P)));
    lowest.distance_m = normal_W.dot(lowest.point_a - X_WH.translation());
    return lowest;
  });
  answer.normal = -normal_W;
  answer.point_b = answer.point_a + answer.distance_m * answer.normal;
  answer.bound_m = a.shape.bound_m;
  answer.accuracy = answer.bound_m > 0 ? Accuracy::kBounded : Accuracy::kExact;
  return answer;
}

// A callback of Bullet's walk over triangles that measures the convex piece against each.
class NearestTriangle final : public btTriangleCallback {
 public:
  NearestTriangle(const btConvexShape& piece, const btTransform& X_WP, const btTransform& X_WM)
      : piece_(piece), X_WP_(X_WP), X_WM_(X_WM) {}

  void processTriangle(btVector3* corners, int, int) override {
    btTriangleShape triangle(corners[0], corners[1], corners[2]);
    triangle.setMargin(0);
    const auto answer = BulletGjkDistance(piece_, X_WP_, triangle, X_WM_);
    failed = failed || !answer.has_value();
    if (answer.has_value() && answer->distance_m < nearest.distance_m) nearest = *answer;
  }

  PairDistance nearest{.distance_m = std::numeric_limits<double>::infinity()};
  bool failed = false;  // a triangle without an answer might be the nearest

 private:
  const btConvexShape& piece_;
  const btTransform& X_WP_;
  const btTransform& X_WM_;
};

// Searches the triangles within a reach of the piece, which grows until the nearest lies within it.
// Empty if Bullet has no answer for one of the triangles.
std::optional<PairDistance> NearestOnMesh(const BulletPiece& piece, const Pose& X_WA,
                                          const BulletMesh& mesh, const Pose& X_WM,
                                          double max_distance_m) {
  const Pose X_WP = X_WA * piece.X_SP;
  const btTransform X_WP_bt = ToBullet(X_WP);
  const btTransform X_WM_bt = ToBullet(X_WM);
  btVector3 low, high, mesh_low, mesh_high;
  piece.shape->getAabb(ToBullet(X_WM.inverse(Eigen::Isometry) * X_WP), low, high);
  mesh.shape->getAabb(btTransform::getIdentity(), mesh_low, mesh_high);
  const double farthest_m = (high - low).length() + (mesh_high - mesh_low).length() +
                            (0.5 * (low + high) - 0.5 * (mesh_low + mesh_high)).length();
  const double limit_m = std::clamp(max_distance_m, 0.0, farthest_m);
  double reach_m = std::min(limit_m, 1e-3 + 0.1 * (high - low).length());
  while (true) {
    NearestTriangle search(*piece.shape, X_WP_bt, X_WM_bt);
    const btVector3 reach(reach_m, reach_m, reach_m);
    mesh.shape->processAllTriangles(&search, low - reach, high + reach);
    if (search.failed) return std::nullopt;
    if (search.nearest.distance_m <= reach_m || reach_m >= limit_m) return search.nearest;
    reach_m = std::min(limit_m, std::max({2 * reach_m, kTouching_m}));
  }
}

PairDistance MeshDistance(const BulletForm& a, const Pose& X_WA, const BulletForm& m,
                          const Pose& X_WM, double max_distance_m) {
  if (EitherContainsOther(*a.solid, X_WA, *m.solid, X_WM)) {
    return OverlapBound(*a.solid, X_WA, *m.solid, X_WM);
  }
  bool failed = false;
  PairDistance answer = MinOverPieces(a.shape.pieces.size(), 1, [&](std::size_t i, std::size_t) {
    const auto nearest =
        NearestOnMesh(a.shape.pieces[i], X_WA, *m.shape.mesh, X_WM, max_distance_m);
    failed = failed || !nearest.has_value();
    return nearest.value_or(PairDistance{});
  });
  if (failed) return WithoutBullet(a, X_WA, m, X_WM);
  if (answer.distance_m <= 0) {
    // An overlap with a circumscribed piece does not prove an overlap with the shape inside it.
    return a.shape.bound_m > 0 ? WithoutBullet(a, X_WA, m, X_WM)
                               : OverlapBound(*a.solid, X_WA, *m.solid, X_WM);
  }
  answer.bound_m += a.shape.bound_m;
  answer.accuracy = m.solid->is_open() ? Accuracy::kSurfaceOnly : Accuracy::kBounded;
  return answer;
}

}  // namespace

bool BulletEngine::Supports(ShapeKind a, ShapeKind b, QueryKind query) const {
  return Allows(kTable, a, b, query);
}

std::shared_ptr<const EngineGeometry> BulletEngine::PrepareFrom(
    std::shared_ptr<const ExactGeometry> exact) const {
  return std::make_shared<const BulletForm>(std::move(exact));
}

bool BulletEngine::Collides(const PlacedGeometry& a, const PlacedGeometry& b, WorkCounter*) const {
  return Distance(a, b, 0, nullptr).distance_m < 0;
}

PairDistance BulletEngine::Distance(const PlacedGeometry& a, const PlacedGeometry& b,
                                    double max_distance_m, WorkCounter*) const {
  const auto rank = [](ShapeKind kind) {  // the one that needs special treatment comes second
    return kind == ShapeKind::kMesh || kind == ShapeKind::kHalfSpace ? kShapeKindCount
                                                                     : static_cast<int>(kind);
  };
  if (rank(a.kind) > rank(b.kind)) return Swapped(Distance(b, a, max_distance_m, nullptr));
  if (b.kind == ShapeKind::kMesh) {
    return MeshDistance(FormOf(a), a.X_WS, FormOf(b), b.X_WS, max_distance_m);
  }
  if (b.kind == ShapeKind::kHalfSpace) return HalfSpaceDistance(FormOf(a), a.X_WS, b.X_WS);
  return ConvexDistance(FormOf(a), a.X_WS, FormOf(b), b.X_WS);
}

}  // namespace cwm::collision
