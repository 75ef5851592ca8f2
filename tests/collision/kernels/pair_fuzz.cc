#include "tests/collision/kernels/pair_fuzz.h"

#include <array>
#include <cmath>
#include <exception>

#include "collision/kernels/exact.h"
#include "tests/collision/kernels/random_pairs.h"

namespace cwm::collision {
namespace {

constexpr int kHullEvery = 16;  // hulls take longer to build than to query
constexpr double kMinDecade = -4, kMaxDecade = 2;
// derived: exact answers are accurate to 1e-7 m, or to a share of the size if rounding is larger,
// see the table in collision/kernels/README.md.
constexpr double kPromise_m = 1e-7, kShare = 2e-8, kUnit = 1e-12;

bool IsBounded(ShapeKind kind) { return kind != ShapeKind::kHalfSpace; }
bool IsBounded(ShapeKind a, ShapeKind b) { return IsBounded(a) && IsBounded(b); }

ShapeKind AnyKind(RandomPairs& random) {
  if (random.Index(kHullEvery) == 0) return ShapeKind::kConvex;
  constexpr std::array<ShapeKind, 7> kQuick = {
      ShapeKind::kSphere,  ShapeKind::kBox,   ShapeKind::kCylinder, ShapeKind::kCone,
      ShapeKind::kCapsule, ShapeKind::kPlate, ShapeKind::kHalfSpace};
  return kQuick[static_cast<std::size_t>(random.Index(static_cast<int>(kQuick.size())))];
}

// The fault of an answer; empty if there is none.
std::string WrongWith(RandomPairs& random, PosedPair pair) {
  const auto a = PrepareExact(pair.a), b = PrepareExact(pair.b);
  PairDistance answer = ExactDistance({*a, pair.X_FA}, {*b, pair.X_FB});
  if (random.Index(2) == 0) {  // touching, up to rounding
    constexpr std::array<double, 5> kOffsets_m = {0, 1e-12, -1e-12, 1e-9, -1e-9};
    const double offset_m = kOffsets_m[static_cast<std::size_t>(random.Index(5))];
    pair.X_FB.translation() -= (answer.distance_m - offset_m) * answer.normal;
    answer = ExactDistance({*a, pair.X_FA}, {*b, pair.X_FB});
  }
  const bool finite = std::isfinite(answer.distance_m) && answer.point_a.allFinite() &&
                      answer.point_b.allFinite() && answer.normal.allFinite();
  if (!finite) return "not finite";
  if (!(std::abs(answer.normal.norm() - 1) <= kUnit)) return "no unit normal";
  const ShapeKind kind_a = KindOf(pair.a), kind_b = KindOf(pair.b);
  const bool bounded = IsBounded(kind_a, kind_b);
  const double size_m = bounded ? SizeOf(pair) : std::pow(10, kMaxDecade);
  const double right_to_m = kPromise_m + kShare * size_m + answer.bound_m;
  const bool overlap = ExactOverlap({*a, pair.X_FA}, {*b, pair.X_FB});
  if (overlap != (answer.distance_m < 0) && std::abs(answer.distance_m) > right_to_m) {
    return "yes or no is not the sign of the distance";
  }
  if (!bounded || answer.distance_m >= 0) return "";
  // Moved along the normal by the depth, B is beyond A: the normal is a separating axis.
  const double left_m = OverlapAlong(pair, answer.normal) + answer.distance_m;
  return left_m > right_to_m ? "moving does not separate" : "";
}

}  // namespace

PairFuzz FuzzPairs(unsigned seed, std::int64_t pairs) {
  RandomPairs random(seed, kMinDecade, kMaxDecade);
  PairFuzz fuzz;
  while (fuzz.pairs < pairs) {
    const ShapeKind a = AnyKind(random), b = AnyKind(random);
    if (!IsBounded(a) && !IsBounded(b)) continue;  // a layer, or no depth: not tested
    ++fuzz.pairs;
    std::string wrong;
    try {
      wrong = WrongWith(random, random.Pair(a, b));
    } catch (const std::exception& thrown) {
      wrong = std::string("thrown: ") + thrown.what();
    }
    if (wrong.empty()) continue;
    if (++fuzz.failures > 1) continue;
    fuzz.first = std::string(NameOf(a)) + " – " + std::string(NameOf(b)) + ": " + wrong;
  }
  return fuzz;
}

}  // namespace cwm::collision
