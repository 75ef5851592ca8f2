#include "collision/engines/fcl_engine.h"

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <optional>
#include <utility>

#include "collision/engines/capability_table.h"
#include "collision/engines/fcl_geometry.h"
#include "collision/engines/piecewise.h"
#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {
namespace {

constexpr Capability N = Capability::kNothing;
constexpr Capability C = Capability::kCollides;
constexpr Capability A = Capability::kAll;

// The queries that FCL answers; the kernels answer the rest, all of which involve half-spaces.
// For half-spaces distance() has no solver and crashes. collide() is right for convex shapes except
// cones (it misses some that lie apex down), returns nothing for two half-spaces, and treats a mesh
// as a surface only.
constexpr CapabilityTable kTable = {{
    //                 sph box cyl con cap half pla cvx mesh
    /* sphere     */ {{A, A, A, A, A, C, A, A, A}},
    /* box        */ {{A, A, A, A, A, C, A, A, A}},
    /* cylinder   */ {{A, A, A, A, A, C, A, A, A}},
    /* cone       */ {{A, A, A, A, A, N, A, A, A}},
    /* capsule    */ {{A, A, A, A, A, C, A, A, A}},
    /* half-space */ {{C, C, C, N, C, N, C, C, N}},
    /* plate      */ {{A, A, A, A, A, C, A, A, A}},
    /* convex     */ {{A, A, A, A, A, C, A, A, A}},
    /* mesh       */ {{A, A, A, A, A, N, A, A, A}},
}};
static_assert(IsSymmetric(kTable));

// True if collide(), or the kernels in its place, use a closed form rather than a search; a <= b.
bool HasFormula(ShapeKind a, ShapeKind b) {
  if (a == ShapeKind::kHalfSpace || b == ShapeKind::kHalfSpace) return true;
  if (a == ShapeKind::kSphere) {
    return b == ShapeKind::kSphere || b == ShapeKind::kBox || b == ShapeKind::kCylinder ||
           b == ShapeKind::kCapsule || b == ShapeKind::kMesh;
  }
  return a == b && (a == ShapeKind::kBox || a == ShapeKind::kMesh);
}

// The tolerance at which GJK stops. FCL's default of 1e-6 is also its largest error.
constexpr double kDistanceTolerance_m = 1e-9;

// An allowance for rounding in closed forms and in ProvenGap_m.
constexpr double kRounding_m = 1e-7;

// A distance and witness points that differ by more than this contradict each other.
constexpr double kConsistencyTolerance_m = 1e-5;

// Witness points nearer than this do not define a direction.
constexpr double kTouching_m = 1e-9;

struct FclForm final : EngineGeometry {
  explicit FclForm(std::shared_ptr<const ExactGeometry> exact)
      : kind(exact->kind()), shape(MakeFclShape(exact->shape())), exact(std::move(exact)) {
    if (kind != ShapeKind::kHalfSpace) solid.emplace(this->exact);
  }
  ShapeKind kind;
  FclShape shape;
  std::shared_ptr<const ExactGeometry> exact;
  std::optional<Solid> solid;  // empty for half-spaces
};

const FclForm& FormOf(const PlacedGeometry& placed) {
  return static_cast<const FclForm&>(placed.geometry);
}

PlacedExact ToPlacedExact(const PlacedGeometry& placed) {
  return {*FormOf(placed).exact, placed.X_WS};
}

bool PiecesCollide(const FclPiece& a, const Pose& X_WA, const FclPiece& b, const Pose& X_WB) {
  const fcl::CollisionRequestd request(/*num_max_contacts=*/1, /*enable_contact=*/false);
  fcl::CollisionResultd result;
  return fcl::collide(a.geometry.get(), X_WA * a.X_SP, b.geometry.get(), X_WB * b.X_SP, request,
                      result) > 0;
}

// A pair ordered so that A's kind is not after B's.
struct FclPair {
  const FclForm& a;
  const Pose& X_WA;
  const FclForm& b;
  const Pose& X_WB;

  bool has_mesh() const { return b.kind == ShapeKind::kMesh; }
};

// Takes FCL's nearest points, on A and on B, into the world frame. For a shape and a mesh, FCL
// returns the point on the mesh first, whatever the order of the arguments; for a sphere and a
// mesh, it returns each point in the frame of its own shape.
void SetWitnesses(const FclPair& pair, const fcl::Vector3d* points, PairDistance& answer) {
  const bool mesh_first = pair.has_mesh() && pair.a.kind != ShapeKind::kMesh;
  answer.point_a = points[mesh_first ? 1 : 0];
  answer.point_b = points[mesh_first ? 0 : 1];
  if (mesh_first && pair.a.kind == ShapeKind::kSphere) {
    answer.point_a = pair.X_WA * answer.point_a;
    answer.point_b = pair.X_WB * answer.point_b;
  }
}

// A positive distance, or -1 for an overlap. Empty if FCL fails or contradicts itself.
std::optional<PairDistance> PieceDistance(const FclPair& pair, const FclPiece& a,
                                          const FclPiece& b) {
  fcl::DistanceRequestd request(/*enable_nearest_points=*/true, /*enable_signed_distance=*/false);
  request.distance_tolerance = kDistanceTolerance_m;
  fcl::DistanceResultd result;
  try {
    fcl::distance(a.geometry.get(), pair.X_WA * a.X_SP, b.geometry.get(), pair.X_WB * b.X_SP,
                  request, result);
  } catch (const std::exception&) {  // FailedAtThisConfiguration and other logic errors
    return std::nullopt;
  }
  if (!std::isfinite(result.min_distance)) return std::nullopt;
  if (result.min_distance <= kTouching_m) {
    if (!PiecesCollide(a, pair.X_WA, b, pair.X_WB)) return std::nullopt;
    return PairDistance{.distance_m = -1};
  }
  PairDistance answer{.solver = Solver::kEngine};
  SetWitnesses(pair, result.nearest_points, answer);
  const Vector3 between = answer.point_b - answer.point_a;
  answer.distance_m = between.norm();
  if (!(std::abs(answer.distance_m - result.min_distance) < kConsistencyTolerance_m))
    return std::nullopt;
  answer.normal = between / answer.distance_m;
  return answer;
}

PairDistance ByKernels(const FclPair& pair) {
  return ExactDistance({pair.a.solid->exact(), pair.X_WA}, {pair.b.solid->exact(), pair.X_WB});
}

double Reach_m(const ConvexCore& core, const Vector3& direction) {
  return SupportPoint(core, direction).dot(direction) + core.radius_m;
}

// The gap between the convex pieces i and j along the unit direction. Their distance is never less.
double ProvenGap_m(const FclPair& pair, std::size_t i, std::size_t j, const Vector3& direction_W) {
  const Vector3 in_a = pair.X_WA.linear().transpose() * direction_W;
  const Vector3 in_b = pair.X_WB.linear().transpose() * -direction_W;
  const Vector3 p_AB_W = pair.X_WB.translation() - pair.X_WA.translation();
  return p_AB_W.dot(direction_W) - Reach_m(pair.a.solid->exact().pieces()[i], in_a) -
         Reach_m(pair.b.solid->exact().pieces()[j], in_b);
}

// Sets the accuracy and the bound of a positive distance. FCL's GJK sometimes stops early
// (measured: 6 mm too far in one of a thousand pairs of cones and cylinders; 14 mm for a box that
// faces a mesh squarely). Between convex shapes, the gap along the normal bounds the error; for
// meshes, only FCL's closed forms are reliable.
void Label(const FclPair& pair, double proven_m, PairDistance& answer) {
  const double pieces_m = pair.a.shape.bound_m + pair.b.shape.bound_m;
  const bool is_open = pair.a.solid->is_open() || pair.b.solid->is_open();
  const bool closed_form = pair.a.kind == ShapeKind::kSphere || pair.a.kind == ShapeKind::kMesh;
  if (pair.has_mesh()) {
    answer.accuracy = is_open ? Accuracy::kSurfaceOnly : Accuracy::kBounded;
    answer.bound_m = kRounding_m;
    if (!closed_form) {
      answer.accuracy = Accuracy::kDegraded;
      answer.bound_m = 0;
    }
    return;
  }
  answer.accuracy = Accuracy::kBounded;
  answer.bound_m = kRounding_m + std::max(pieces_m, answer.distance_m - proven_m);
}

PairDistance FclDistance(const FclPair& pair) {
  const Solid& solid_a = *pair.a.solid;
  const Solid& solid_b = *pair.b.solid;
  if (pair.has_mesh() && EitherContainsOther(solid_a, pair.X_WA, solid_b, pair.X_WB)) {
    return OverlapBound(solid_a, pair.X_WA, solid_b, pair.X_WB);
  }
  const auto& pieces_a = pair.a.shape.pieces;
  const auto& pieces_b = pair.b.shape.pieces;
  bool failed = false;
  double proven_m = std::numeric_limits<double>::infinity();
  PairDistance answer =
      MinOverPieces(pieces_a.size(), pieces_b.size(), [&](std::size_t i, std::size_t j) {
        const auto piece = PieceDistance(pair, pieces_a[i], pieces_b[j]);
        failed = failed || !piece.has_value();
        if (!pair.has_mesh() && piece.has_value() && piece->distance_m > 0) {
          proven_m = std::min(proven_m, ProvenGap_m(pair, i, j, piece->normal));
        }
        return piece.value_or(PairDistance{.distance_m = -1});
      });
  if (failed) return ByKernels(pair);
  if (answer.distance_m < 0) {
    // An overlap of circumscribed pieces does not prove an overlap of the shapes inside them.
    const bool is_stand_in = pair.a.shape.bound_m + pair.b.shape.bound_m > 0;
    return pair.has_mesh() && !is_stand_in ? OverlapBound(solid_a, pair.X_WA, solid_b, pair.X_WB)
                                           : ByKernels(pair);
  }
  Label(pair, proven_m, answer);
  return answer;
}

}  // namespace

bool FclEngine::Supports(ShapeKind, ShapeKind, QueryKind) const { return true; }

Accuracy FclEngine::CollisionAccuracy(ShapeKind a, ShapeKind b) const {
  return HasFormula(std::min(a, b), std::max(a, b)) ? Accuracy::kExact : Accuracy::kDegraded;
}

std::shared_ptr<const EngineGeometry> FclEngine::PrepareFrom(
    std::shared_ptr<const ExactGeometry> exact) const {
  return std::make_shared<const FclForm>(std::move(exact));
}

bool FclEngine::Collides(const PlacedGeometry& a, const PlacedGeometry& b,
                         WorkCounter* work) const {
  if (a.kind > b.kind) return Collides(b, a, work);  // halves the number of FCL's solvers in use
  if (!Allows(kTable, a.kind, b.kind, QueryKind::kCollides)) {
    return ExactOverlap(ToPlacedExact(a), ToPlacedExact(b), work);
  }
  const FclForm& form_a = FormOf(a);
  const FclForm& form_b = FormOf(b);
  for (const FclPiece& piece_a : form_a.shape.pieces) {
    for (const FclPiece& piece_b : form_b.shape.pieces) {
      if (PiecesCollide(piece_a, a.X_WS, piece_b, b.X_WS)) return true;
    }
  }
  if (b.kind != ShapeKind::kMesh) return false;
  return EitherContainsOther(*form_a.solid, a.X_WS, *form_b.solid, b.X_WS);
}

PairDistance FclEngine::Distance(const PlacedGeometry& a, const PlacedGeometry& b,
                                 double max_distance_m, WorkCounter* work) const {
  if (a.kind > b.kind) return Swapped(Distance(b, a, max_distance_m, work));
  if (!Allows(kTable, a.kind, b.kind, QueryKind::kDistance)) {
    return ExactDistance(ToPlacedExact(a), ToPlacedExact(b), max_distance_m, work);
  }
  return FclDistance({FormOf(a), a.X_WS, FormOf(b), b.X_WS});
}

}  // namespace cwm::collision
