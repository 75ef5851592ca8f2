// The accuracy of the exact kernels: against formulas in extended precision, against certificates,
// and over many difficult pairs.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "collision/geometry/tessellate.h"
#include "collision/kernels/exact.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/collision/kernels/long_double_oracle.h"
#include "tests/collision/kernels/pair_fuzz.h"
#include "tests/collision/kernels/random_pairs.h"

namespace cwm::benchmarks {
namespace {

using collision::ExactDistance;
using collision::PairDistance;
using collision::PairFuzz;
using collision::PosedPair;
using collision::RandomPairs;

constexpr std::array<ShapeKind, 8> kKinds = {
    ShapeKind::kSphere,  ShapeKind::kBox,    ShapeKind::kCylinder, ShapeKind::kCone,
    ShapeKind::kCapsule, ShapeKind::kConvex, ShapeKind::kPlate,    ShapeKind::kHalfSpace};
constexpr int kFormulaPairs = 4'000, kIteratedPairs = 400;  // of each pair of kinds
constexpr int kSearchedDirections = 200;
constexpr double kDeepest_m = 0.02, kFarthest_m = 1;

constexpr std::int64_t kFuzzPairs = 10'000'000;
constexpr int kFuzzThreads = 2;

PairDistance Solve(const PosedPair& pair) {
  const auto a = collision::PrepareExact(pair.a), b = collision::PrepareExact(pair.b);
  return ExactDistance({*a, pair.X_FA}, {*b, pair.X_FB});
}

// Calls evaluate(a, b) for the ordered pairs of kinds that have a formula, or for those that have
// none.
template <class Function>
void ForEachPairOfKinds(bool of_formulas, const Function& evaluate) {
  for (const ShapeKind a : kKinds) {
    for (const ShapeKind b : kKinds) {
      if (a == ShapeKind::kHalfSpace && b == a) continue;  // overlap in a layer, or without bound
      if (collision::HasLongDoubleOracle(a, b) == of_formulas) evaluate(a, b);
    }
  }
}

double WorstOfFormula(ShapeKind a, ShapeKind b) {
  RandomPairs random(41);
  double worst = 0;
  for (int k = 0; k < kFormulaPairs; ++k) {
    PosedPair pair = random.Pair(a, b);
    if (k % 2 == 1) {
      const PairDistance answer = Solve(pair);
      const double distance_m = random.Uniform(-kDeepest_m, k % 4 == 1 ? kDeepest_m : kFarthest_m);
      pair.X_FB.translation() += (distance_m - answer.distance_m) * answer.normal;
    }
    const auto truth_m = static_cast<double>(collision::LongDoubleDistance_m(pair));
    const double size_m = std::max(collision::ExtentOf(pair), 1e-3);
    worst = std::max(worst, std::abs(Solve(pair).distance_m - truth_m) / size_m);
  }
  return worst;
}

// The sizes that pairs are drawn with.
enum class Sizes { kTwentyCentimetres, kHands, kAny };
constexpr std::array kAllSizes = {Sizes::kTwentyCentimetres, Sizes::kHands, Sizes::kAny};

std::string_view NameOf(Sizes sizes) {
  switch (sizes) {
    case Sizes::kTwentyCentimetres:
      return "20 cm across";
    case Sizes::kHands:
      return "each dimension 5 to 20 cm";
    case Sizes::kAny:
      break;
  }
  return "dimensions of 1 mm to 10 m";
}

// The largest error of some answers, and the pair that has it.
struct Worst {
  double error_m = 0;
  std::string of;
  double exact_m = 0;  // of those that are labelled EXACT
};

Shape TwentyCentimetres(ShapeKind kind) {
  switch (kind) {
    case ShapeKind::kSphere:
      return Sphere{0.1};
    case ShapeKind::kBox:
      return Box{{0.2, 0.2, 0.2}};
    case ShapeKind::kCylinder:
      return Cylinder{0.1, 0.2};
    case ShapeKind::kCone:
      return Cone{0.1, 0, 0.2};
    case ShapeKind::kCapsule:
      return Capsule{0.05, 0.1};
    case ShapeKind::kConvex:
      return Convex{std::make_shared<const TriangleMesh>(Tessellate(Box{{0.2, 0.2, 0.2}}))};
    case ShapeKind::kPlate:
      return Plate{{{0, 0}, {0.2, 0}, {0.2, 0.2}, {0, 0.2}}, {}, 0.02};
    case ShapeKind::kHalfSpace:
    case ShapeKind::kMesh:
      break;
  }
  return HalfSpace{};
}

PosedPair Draw(Sizes sizes, RandomPairs& random, ShapeKind a, ShapeKind b) {
  switch (sizes) {
    case Sizes::kTwentyCentimetres:
      return {TwentyCentimetres(a), TwentyCentimetres(b), random.AnyPose(2), random.AnyPose(2)};
    case Sizes::kHands:
      return random.HandSizedPair(a, b);
    case Sizes::kAny:
      break;
  }
  return random.Pair(a, b);
}

// The error by certificates: the gap along the normal proves a lower bound of a distance, the
// witness points an upper bound; for an overlap, by a search for a smaller one.
double ErrorOf_m(const PosedPair& pair, const PairDistance& answer) {
  const double error_m = collision::ErrorsOf(pair, answer).distance_m;
  if (answer.distance_m >= 0) return error_m;
  const double min_overlap_m = collision::SearchMinOverlap(pair, kSearchedDirections, 3);
  return std::max(error_m, -answer.distance_m - min_overlap_m);
}

// Error bounds that answers state are not subtracted.
void Iterate(Sizes sizes, ShapeKind a, ShapeKind b, Worst& worst) {
  RandomPairs random(43);
  for (int k = 0; k < kIteratedPairs; ++k) {
    PosedPair pair = Draw(sizes, random, a, b);
    const PairDistance first = Solve(pair);
    const double target_m = random.Uniform(-kDeepest_m, k % 2 == 0 ? kDeepest_m : kFarthest_m);
    pair.X_FB.translation() += (target_m - first.distance_m) * first.normal;
    const PairDistance answer = Solve(pair);
    const double error_m = ErrorOf_m(pair, answer);
    if (answer.accuracy == collision::Accuracy::kExact)
      worst.exact_m = std::max(worst.exact_m, error_m);
    if (error_m <= worst.error_m) continue;
    char text[160];
    std::snprintf(text, sizeof(text), "%s - %s at %.3g m%s", std::string(cwm::NameOf(a)).c_str(),
                  std::string(cwm::NameOf(b)).c_str(), answer.distance_m,
                  answer.accuracy == collision::Accuracy::kExact ? "" : ", labelled BOUNDED");
    worst.error_m = error_m;
    worst.of = text;
  }
}

PairFuzz FuzzOnThreads() {
  std::array<PairFuzz, kFuzzThreads> of;
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < kFuzzThreads; ++t) {
    threads.emplace_back(
        [&of, t] { of[t] = collision::FuzzPairs(100 + t, kFuzzPairs / kFuzzThreads); });
  }
  for (std::thread& thread : threads) thread.join();
  PairFuzz all;
  for (const PairFuzz& some : of) {
    all.pairs += some.pairs;
    all.failures += some.failures;
    if (all.first.empty()) all.first = some.first;
  }
  return all;
}

}  // namespace

void MeasureOracles(Report& report) {
  double worst_of_formulas = 0;
  ForEachPairOfKinds(true, [&](ShapeKind a, ShapeKind b) {
    worst_of_formulas = std::max(worst_of_formulas, WorstOfFormula(a, b));
  });
  report.Add({.key = "closed_form_worst_rel",
              .value = worst_of_formulas,
              .unit = "1",
              .how = "pairs with a formula, 1 mm to 10 m, against extended precision; share of the "
                     "larger extent or offset"});
  double iterative_m = 0;
  for (const Sizes sizes : kAllSizes) {
    Worst worst;
    ForEachPairOfKinds(false, [&](ShapeKind a, ShapeKind b) { Iterate(sizes, a, b, worst); });
    iterative_m = std::max(iterative_m, worst.error_m);
    char text[320];
    std::snprintf(
        text, sizeof(text), "without a formula, %s: %.2g m at worst (%s), of EXACT ones %.2g m",
        std::string(NameOf(sizes)).c_str(), worst.error_m, worst.of.c_str(), worst.exact_m);
    report.Detail(text);
  }
  report.Add(
      {.key = "iterative_worst_m",
       .value = iterative_m,
       .unit = "m",
       .how = "the other pairs, 20 cm, 5 to 20 cm and 1 mm to 10 m, from -20 mm to 1 m, against "
              "certificates; what answers state as their bound is not taken off"});
  const PairFuzz fuzz = FuzzOnThreads();
  report.Add({.key = "fuzz_pairs",
              .value = static_cast<double>(fuzz.pairs),
              .unit = "1",
              .how = "random pairs, 0.1 mm to 100 m, half of them kissing, two thirds aligned"});
  report.Add({.key = "fuzz_failures",
              .value = static_cast<double>(fuzz.failures),
              .unit = "1",
              .how = fuzz.failures == 0 ? "nothing thrown, no number that is none, every normal "
                                          "unit and an axis that parts the two"
                                        : "the first: " + fuzz.first});
}

}  // namespace cwm::benchmarks
