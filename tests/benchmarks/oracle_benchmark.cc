// How right the exact kernels are: against formulas in extended precision, against certificates, and
// over many pairs that hurt.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

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

template <class Ask>
double WorstOverPairs(const Ask& ask, bool of_formulas) {
  double worst = 0;
  for (const ShapeKind a : kKinds) {
    for (const ShapeKind b : kKinds) {
      if (a == ShapeKind::kHalfSpace && b == a) continue;  // a layer, or no depth
      if (collision::HasLongDoubleOracle(a, b) != of_formulas) continue;
      worst = std::max(worst, ask(a, b));
    }
  }
  return worst;
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

// Beyond the bound that the answer states.
double WorstOfIteration_m(ShapeKind a, ShapeKind b) {
  RandomPairs random(43);
  double worst_m = 0;
  for (int k = 0; k < kIteratedPairs; ++k) {
    PosedPair pair = random.HandSizedPair(a, b);
    const PairDistance first = Solve(pair);
    const double target_m = random.Uniform(-kDeepest_m, k % 2 == 0 ? kDeepest_m : kFarthest_m);
    pair.X_FB.translation() += (target_m - first.distance_m) * first.normal;
    const PairDistance answer = Solve(pair);
    double error_m = collision::ErrorsOf(pair, answer).distance_m;
    if (answer.distance_m < 0) {
      const double least_m = collision::SearchedLeastOverlap(pair, kSearchedDirections, 3);
      error_m = std::max(error_m, -answer.distance_m - least_m);
    }
    worst_m = std::max(worst_m, error_m - answer.bound_m);
  }
  return worst_m;
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
  report.Add({.key = "closed_form_worst_rel",
              .value = WorstOverPairs(WorstOfFormula, true),
              .unit = "1",
              .how = "pairs with a formula, 1 mm to 10 m, against extended precision; share of the "
                     "larger extent or offset"});
  report.Add({.key = "iterative_worst_m",
              .value = WorstOverPairs(WorstOfIteration_m, false),
              .unit = "m",
              .how = "the other pairs, 5 to 20 cm, from -20 mm to 1 m, against certificates"});
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
