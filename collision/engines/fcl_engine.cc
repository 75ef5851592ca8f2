#include "collision/engines/fcl_engine.h"

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <cmath>
#include <exception>
#include <optional>
#include <utility>

#include "collision/engines/fcl_geometry.h"
#include "collision/engines/piecewise.h"
#include "collision/engines/trust_table.h"
#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {
namespace {

constexpr Ability N = Ability::kNothing;
constexpr Ability C = Ability::kCollides;
constexpr Ability A = Ability::kAll;

// Half-spaces: distance() has no solver for any pair and crashes; collide() has one for every
// convex shape, but none for another half-space that tells the parallel case, and none for meshes
// that looks below the surface.
constexpr TrustTable kTable = {{
    //                 sph box cyl con cap half pla cvx mesh
    /* sphere     */ {{A, A, A, A, A, C, A, A, A}},
    /* box        */ {{A, A, A, A, A, C, A, A, A}},
    /* cylinder   */ {{A, A, A, A, A, C, A, A, A}},
    /* cone       */ {{A, A, A, A, A, C, A, A, A}},
    /* capsule    */ {{A, A, A, A, A, C, A, A, A}},
    /* half-space */ {{C, C, C, C, C, N, C, C, N}},
    /* plate      */ {{A, A, A, A, A, C, A, A, A}},
    /* convex     */ {{A, A, A, A, A, C, A, A, A}},
    /* mesh       */ {{A, A, A, A, A, N, A, A, A}},
}};
static_assert(IsSymmetric(kTable));

// Where GJK stops: FCL's default of 1e-6 is its largest error as well.
constexpr double kDistanceTolerance_m = 1e-9;

// Worst error of a separated distance seen against the exact kernels (contract suite), rounded up.
constexpr double kSeparatedBound_m = 1e-6;

// Witnesses nearer than this do not tell a direction.
constexpr double kTouching_m = 1e-9;

struct FclForm final : EngineGeometry {
  explicit FclForm(std::shared_ptr<const ExactGeometry> exact)
      : kind(exact->kind()), shape(MakeFclShape(exact->shape())) {
    if (kind != ShapeKind::kHalfSpace) solid.emplace(std::move(exact));
  }
  ShapeKind kind;
  FclShape shape;
  std::optional<Solid> solid;  // all but half-spaces
};

const FclForm& FormOf(const PlacedGeometry& placed) {
  return static_cast<const FclForm&>(placed.geometry);
}

bool PiecesCollide(const FclPiece& a, const Pose& X_WA, const FclPiece& b, const Pose& X_WB) {
  const fcl::CollisionRequestd request(/*num_max_contacts=*/1, /*enable_contact=*/false);
  fcl::CollisionResultd result;
  return fcl::collide(a.geometry.get(), X_WA * a.X_SP, b.geometry.get(), X_WB * b.X_SP, request,
                      result) > 0;
}

PairDistance FromWitnesses(double distance_m, const fcl::Vector3d* points) {
  PairDistance answer{.distance_m = distance_m, .point_a = points[0], .point_b = points[1]};
  answer.normal = (answer.point_b - answer.point_a) / distance_m;
  answer.normal.normalize();
  return answer;
}

enum class Sign { kUnsigned, kSigned };

// What FCL says, nothing when it fails or contradicts itself. An overlap asked for unsigned is an
// answer with distance -1 that means nothing else.
std::optional<PairDistance> AskFcl(const FclPiece& a, const Pose& X_WA, const FclPiece& b,
                                   const Pose& X_WB, Sign sign) {
  fcl::DistanceRequestd request(/*enable_nearest_points=*/true, sign == Sign::kSigned);
  request.distance_tolerance = kDistanceTolerance_m;
  fcl::DistanceResultd result;
  try {
    fcl::distance(a.geometry.get(), X_WA * a.X_SP, b.geometry.get(), X_WB * b.X_SP, request,
                  result);
  } catch (const std::exception&) {  // FailedAtThisConfiguration and other logic errors
    return std::nullopt;
  }
  const double distance_m = result.min_distance;
  if (sign == Sign::kUnsigned && distance_m <= 0) return PairDistance{.distance_m = -1};
  if (!(std::abs(distance_m) > kTouching_m) || !std::isfinite(distance_m)) return std::nullopt;
  const fcl::Vector3d* points = result.nearest_points;
  constexpr double kContradiction_m = 1e-5;  // far above any rounding, far below any use
  const double apart_m = (points[1] - points[0]).norm();
  if (!(std::abs(apart_m - std::abs(distance_m)) < kContradiction_m)) return std::nullopt;
  return FromWitnesses(distance_m, points);
}

// One question about two convex shapes: unsigned, then signed where they overlap, then the exact
// kernels, then the bounding boxes.
class ConvexPair {
 public:
  ConvexPair(const FclForm& a, const Pose& X_WA, const FclForm& b, const Pose& X_WB)
      : a_(a), X_WA_(X_WA), b_(b), X_WB_(X_WB) {}

  PairDistance Answer() const {
    const std::size_t count_a = a_.shape.pieces.size();
    const std::size_t count_b = b_.shape.pieces.size();
    bool failed = false;
    PairDistance answer =
        LeastOverPieces(count_a, count_b, [&](std::size_t i, std::size_t j) -> PairDistance {
          std::optional<PairDistance> piece = OfPieces(a_.shape.pieces[i], b_.shape.pieces[j]);
          failed = failed || !piece.has_value();
          return piece.value_or(PairDistance{.distance_m = 0});
        });
    if (failed) return WithoutFcl();
    answer.trust = Trust::kBounded;
    answer.bound_m = a_.shape.bound_m + b_.shape.bound_m + kSeparatedBound_m;
    if (answer.distance_m >= 0) return answer;
    answer.trust = Trust::kDegraded;  // EPA of libccd states no error
    if (count_a * count_b > 1)
      WidenToUnion(answer, OverlapBound(*a_.solid, X_WA_, *b_.solid, X_WB_));
    return answer;
  }

 private:
  std::optional<PairDistance> OfPieces(const FclPiece& a, const FclPiece& b) const {
    const auto apart = AskFcl(a, X_WA_, b, X_WB_, Sign::kUnsigned);
    if (apart.has_value() && apart->distance_m > 0) return apart;
    return AskFcl(a, X_WA_, b, X_WB_, Sign::kSigned);
  }

  PairDistance WithoutFcl() const {
    if (ExactSupports(a_.kind, b_.kind))
      return ExactDistance({a_.solid->exact(), X_WA_}, {b_.solid->exact(), X_WB_});
    PairDistance answer = OverlapBound(*a_.solid, X_WA_, *b_.solid, X_WB_);
    answer.trust = Trust::kDegraded;
    return answer;
  }

  const FclForm& a_;
  const Pose& X_WA_;
  const FclForm& b_;
  const Pose& X_WB_;
};

// FCL measures to the triangles; what overlaps has a depth that only the bounding boxes limit.
PairDistance MeshDistance(const FclForm& a, const Pose& X_WA, const FclForm& b, const Pose& X_WB) {
  const bool is_open = a.solid->is_open() || b.solid->is_open();
  if (OneHoldsPartOfOther(*a.solid, X_WA, *b.solid, X_WB)) {
    return OverlapBound(*a.solid, X_WA, *b.solid, X_WB);
  }
  bool crossing = false;
  PairDistance answer = LeastOverPieces(
      a.shape.pieces.size(), b.shape.pieces.size(), [&](std::size_t i, std::size_t j) {
        const auto piece =
            AskFcl(a.shape.pieces[i], X_WA, b.shape.pieces[j], X_WB, Sign::kUnsigned);
        crossing = crossing || !piece.has_value() || piece->distance_m <= 0;
        return piece.value_or(PairDistance{.distance_m = -1});
      });
  if (crossing) return OverlapBound(*a.solid, X_WA, *b.solid, X_WB);
  answer.bound_m = a.shape.bound_m + b.shape.bound_m + kSeparatedBound_m;
  answer.trust = is_open ? Trust::kSurfaceOnly : Trust::kBounded;
  return answer;
}

}  // namespace

bool FclEngine::Supports(ShapeKind a, ShapeKind b, Question question) const {
  return Allows(kTable, a, b, question);
}

std::shared_ptr<const EngineGeometry> FclEngine::PrepareFrom(
    std::shared_ptr<const ExactGeometry> exact) const {
  return std::make_shared<const FclForm>(std::move(exact));
}

bool FclEngine::Collides(const PlacedGeometry& a, const PlacedGeometry& b) const {
  if (a.kind > b.kind) return Collides(b, a);  // half the pairs of solvers to trust
  const FclForm& form_a = FormOf(a);
  const FclForm& form_b = FormOf(b);
  for (const FclPiece& piece_a : form_a.shape.pieces) {
    for (const FclPiece& piece_b : form_b.shape.pieces) {
      if (PiecesCollide(piece_a, a.X_WS, piece_b, b.X_WS)) return true;
    }
  }
  if (b.kind != ShapeKind::kMesh) return false;
  return OneHoldsPartOfOther(*form_a.solid, a.X_WS, *form_b.solid, b.X_WS);
}

PairDistance FclEngine::Distance(const PlacedGeometry& a, const PlacedGeometry& b,
                                 double max_distance_m) const {
  if (a.kind > b.kind) return Swapped(Distance(b, a, max_distance_m));
  if (b.kind == ShapeKind::kMesh) return MeshDistance(FormOf(a), a.X_WS, FormOf(b), b.X_WS);
  return ConvexPair(FormOf(a), a.X_WS, FormOf(b), b.X_WS).Answer();
}

}  // namespace cwm::collision
