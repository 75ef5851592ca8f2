#include "tests/contract/worst_errors.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "collision/engines/engine.h"
#include "collision/kernels/exact.h"
#include "tests/collision/kernels/long_double_oracle.h"
#include "tests/collision/kernels/random_pairs.h"
#include "tests/contract/libccd_referee.h"

namespace cwm::collision {
namespace {

constexpr double kMaxDepth_m = 0.02, kMaxDistance_m = 1;
constexpr int kSearchedDirections = 200;
// chosen: errors below this are the rounding of poses, and are not distinguished in the table.
constexpr double kRounding_m = 1e-15;

std::vector<Shape> TwentyCentimetreShapes() {
  return {Sphere{0.1},
          Box{{0.2, 0.2, 0.2}},
          Cylinder{0.1, 0.2},
          Cone{0.1, 0, 0.2},
          Capsule{0.05, 0.1},
          HalfSpace{},
          Plate{{{0, 0}, {0.2, 0}, {0.2, 0.2}, {0, 0.2}}, {}, 0.02}};
}

PairDistance KernelDistance(const PosedPair& pair) {
  const auto a = PrepareExact(pair.a), b = PrepareExact(pair.b);
  return ExactDistance({*a, pair.X_FA}, {*b, pair.X_FB});
}

// The pair at a given signed distance, with B moved along the normal.
PosedPair At(PosedPair pair, double distance_m) {
  const PairDistance now = KernelDistance(pair);
  pair.X_FB.translation() += (distance_m - now.distance_m) * now.normal;
  return pair;
}

double TrueDistance_m(const PosedPair& pair) {
  if (HasLongDoubleOracle(KindOf(pair.a), KindOf(pair.b))) {
    return static_cast<double>(LongDoubleDistance_m(pair));
  }
  // The minimum over all directions is the least overlap. The search also starts from the kernels'
  // direction; without it, it misses the best direction by up to 1 mm of depth.
  const PairDistance result = KernelDistance(pair);
  return -std::min(MinOverlapNear(pair, result.normal, -result.distance_m),
                   SearchMinOverlap(pair, kSearchedDirections, 3));
}

std::optional<double> EngineDistance_m(EngineKind kind, const PosedPair& pair) {
  const Engine& engine = GetEngine(kind);
  if (!engine.Supports(KindOf(pair.a), KindOf(pair.b), QueryKind::kDistance)) return std::nullopt;
  const auto a = engine.Prepare(pair.a), b = engine.Prepare(pair.b);
  const PairDistance answer =
      engine.Distance({KindOf(pair.a), *a, pair.X_FA}, {KindOf(pair.b), *b, pair.X_FB},
                      std::numeric_limits<double>::infinity());
  if (kind != EngineKind::kExact && answer.solver != Solver::kEngine) return std::nullopt;
  return answer.distance_m;
}

std::optional<double> RefereeDistance_m(Referee referee, const PosedPair& pair) {
  switch (referee) {
    case Referee::kExact:
      return EngineDistance_m(EngineKind::kExact, pair);
    case Referee::kFcl:
      return EngineDistance_m(EngineKind::kFcl, pair);
    case Referee::kBullet:
      return EngineDistance_m(EngineKind::kBullet, pair);
    case Referee::kLibccd:
      break;
  }
  if (!IsKnownToLibccd(pair.a) || !IsKnownToLibccd(pair.b)) return std::nullopt;
  const std::optional<LibccdDepth> depth =
      LibccdPenetration({pair.a, pair.X_FA}, {pair.b, pair.X_FB});
  if (!depth) return std::nullopt;
  return -depth->depth_m;
}

void Count(const PosedPair& pair, double truth_m, PairErrors& errors) {
  for (int k = 0; k < kRefereeCount; ++k) {
    const std::optional<double> measured_m = RefereeDistance_m(static_cast<Referee>(k), pair);
    if (!measured_m) continue;
    WorstError& of = errors.of[static_cast<std::size_t>(k)];
    std::optional<double>& worst_m = truth_m > 0 ? of.apart_m : of.overlapping_m;
    worst_m = std::max(worst_m.value_or(0), std::abs(*measured_m - truth_m));
  }
}

PairErrors OfKnownAnswers() {
  const Box box{{1, 1, 1}};
  const Sphere ball{0.25};
  struct Known {
    Shape a, b;
    double x_m, distance_m;
  };
  std::vector<Known> all = {{box, Box{{2, 2, 2}}, 0.2, -1.3},
                            {box, Box{{2, 2, 2}}, 1.6, 0.1},
                            {ball, ball, 0.2, -0.3},
                            {ball, ball, 1, 0.5}};
  for (const Shape& shape : {Shape(ball), Shape(Cylinder{0.25, 0.25}), Shape(Cone{0.25, 0, 0.25}),
                             Shape(Capsule{0.25, 0.25})}) {
    all.push_back({box, shape, 0.2, -0.55});
    all.push_back({box, shape, 1, 0.25});
  }
  PairErrors errors{"known answers", {}};
  for (const Known& k : all) {
    Count({k.a, k.b, Pose::Identity(), MakeTranslation(k.x_m, 0, 0)}, k.distance_m, errors);
  }
  return errors;
}

PairErrors OfRandomPoses(const Shape& a, const Shape& b, int poses) {
  PairErrors errors{std::string(NameOf(KindOf(a))) + " – " + std::string(NameOf(KindOf(b))), {}};
  RandomPairs random(23);
  const auto count = [&](const PosedPair& pair) { Count(pair, TrueDistance_m(pair), errors); };
  for (int k = 0; k < poses; ++k) {
    const PosedPair pair{a, b, random.AnyPose(2), random.AnyPose(2)};
    count(At(pair, random.Uniform(-kMaxDepth_m, 0)));
    count(At(pair, random.Uniform(0, k % 2 == 0 ? kMaxDepth_m : kMaxDistance_m)));
  }
  return errors;
}

std::string Rounded(const std::optional<double>& error_m) {
  if (!error_m) return "–";
  const double error = std::max(*error_m, kRounding_m);
  const double power = std::pow(10, std::floor(std::log10(error)));
  char text[32];
  std::snprintf(text, sizeof(text), "%.0e", std::ceil(error / power - 1e-9) * power);
  return text;
}

}  // namespace

std::vector<PairErrors> MeasureWorstErrors(int poses_per_pair) {
  const std::vector<Shape> shapes = TwentyCentimetreShapes();
  std::vector<PairErrors> all = {OfKnownAnswers()};
  for (std::size_t a = 0; a < shapes.size(); ++a) {
    for (std::size_t b = a; b < shapes.size(); ++b) {
      const auto is_endless = [](const Shape& s) { return KindOf(s) == ShapeKind::kHalfSpace; };
      if (is_endless(shapes[a]) && is_endless(shapes[b])) continue;  // a layer, or no depth
      all.push_back(OfRandomPoses(shapes[a], shapes[b], poses_per_pair));
    }
  }
  return all;
}

std::string TableOf(const std::vector<PairErrors>& all) {
  std::string table =
      "| Pair | exact, apart | exact, overlapping | FCL, apart | Bullet, apart | Bullet, "
      "overlapping | "
      "libccd, overlapping |\n|---|---|---|---|---|---|---|\n";
  for (const PairErrors& pair : all) {
    const auto of = [&](Referee referee) { return pair.of[static_cast<std::size_t>(referee)]; };
    table += "| " + pair.pair;
    for (const std::optional<double>& error_m :
         {of(Referee::kExact).apart_m, of(Referee::kExact).overlapping_m, of(Referee::kFcl).apart_m,
          of(Referee::kBullet).apart_m, of(Referee::kBullet).overlapping_m,
          of(Referee::kLibccd).overlapping_m}) {
      table += " | " + Rounded(error_m);
    }
    table += " |\n";
  }
  return table;
}

}  // namespace cwm::collision
