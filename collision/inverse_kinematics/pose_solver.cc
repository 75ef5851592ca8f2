#include "collision/inverse_kinematics/pose_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "collision/inverse_kinematics/ik_steps.h"

namespace cwm::collision {
namespace {

// chosen: what is nearer converges in two or three steps of double precision.
constexpr float kConverged2 = 1e-6F;  // m^2
// chosen: a start is replaced if its error does not fall to this share in kPatience steps, or after
// kMaxStepsPerStart.
constexpr float kProgress = 0.3F;
constexpr int kPatience = 8, kMaxStepsPerStart = 40;
// chosen: steps that refine a start that converged, and the error in m^2 that ends them.
constexpr int kMaxRefinements = 16;
constexpr double kRefined2 = 1e-24;
// chosen: steps of a search from the seed alone, and of the refinement of the nearest values.
constexpr int kStepsOfSeed = 100;
// chosen: rows of draws. A search that needs more starts takes them again.
constexpr std::size_t kDraws = 1024;

// The k-th of evenly distributed numbers in [0, 1) (splitmix64, Steele et al. 2014).
double Draw(std::size_t k) {
  std::uint64_t z = (k + 1) * 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

double DrawFor(const IkVariable& variable, double share) {
  if (variable.turns_endlessly) return std::numbers::pi * (2 * share - 1);
  // chosen: a slide without limits is tried within a metre of zero.
  const double lower = std::isinf(variable.lower) ? -1 : variable.lower;
  const double upper = std::isinf(variable.upper) ? 1 : variable.upper;
  return std::lerp(lower, upper, share);
}

// The value that differs by whole turns and is nearest to the seed.
double NearestTurn(double value, double seed) {
  return value - 2 * std::numbers::pi * std::round((value - seed) / (2 * std::numbers::pi));
}

double AngleOf_rad(double rotation2) {
  return 2 * std::asin(std::min(1.0, 0.5 * std::sqrt(std::max(0.0, rotation2))));
}

}  // namespace

// One call of Solve.
struct PoseSolver::Search {
  const IkChain& chain;
  std::vector<double>& draws;
  const PoseRequest& request;
  IkTarget<double> target = IkTargetOf(request.X_BT);
  PoseAnswer answer = {};
  double nearest2 = std::numeric_limits<double>::infinity();
  IkValues<double, 1> nearest = {};
  std::size_t next_draw = 0;

  std::size_t count() const { return chain.variables.size(); }

  IkValues<double, 1> Seed() const {
    IkValues<double, 1> values;
    for (std::size_t v = 0; v < count(); ++v) {
      const IkVariable& variable = chain.variables[v];
      const double value = request.seed[static_cast<std::size_t>(variable.of_group)];
      values.of[v] = std::clamp(value, variable.lower, variable.upper);
    }
    return values;
  }

  // Steps in double precision until the error is negligible or does not fall any more.
  IkErrors<double, 1> Refine(IkValues<double, 1>& values, int max_steps) const {
    IkValues<double, 1> next = values;
    IkErrors<double, 1> errors = StepIk(chain, target, next);
    for (int step = 0; step < max_steps && errors.Total(0) > kRefined2; ++step) {
      IkValues<double, 1> after = next;
      const IkErrors<double, 1> now = StepIk(chain, target, after);
      if (!(now.Total(0) < errors.Total(0))) break;
      errors = now;
      values = next;
      next = after;
    }
    return errors;
  }

  PoseSolution SolutionOf(const IkValues<double, 1>& values,
                          const IkErrors<double, 1>& errors) const {
    PoseSolution solution{.row = {request.seed.begin(), request.seed.end()},
                          .position_error_m = std::sqrt(errors.position2[0]),
                          .rotation_error_rad = AngleOf_rad(errors.rotation2[0])};
    for (std::size_t v = 0; v < count(); ++v) {
      const IkVariable& variable = chain.variables[v];
      double& value = solution.row[static_cast<std::size_t>(variable.of_group)];
      value = variable.turns_endlessly ? NearestTurn(values.of[v], value) : values.of[v];
    }
    return solution;
  }

  bool IsReached(const PoseSolution& solution) const {
    return solution.position_error_m <= request.position_tolerance_m &&
           solution.rotation_error_rad <= request.rotation_tolerance_rad;
  }

  bool IsKnown(const PoseSolution& solution) const {
    return std::ranges::any_of(answer.solutions, [&](const PoseSolution& known) {
      for (std::size_t k = 0; k < known.row.size(); ++k) {
        if (std::abs(known.row[k] - solution.row[k]) > kDistinctSolutions) return false;
      }
      return true;
    });
  }

  bool is_done() const {
    return std::ssize(answer.solutions) >= std::max(1, request.max_solutions);
  }

  // Refines values and keeps them if they are a new solution.
  bool Accept(IkValues<double, 1> values, int max_steps) {
    const IkErrors<double, 1> errors = Refine(values, max_steps);
    PoseSolution solution = SolutionOf(values, errors);
    if (!IsReached(solution)) {
      Remember(values, errors.Total(0));
      return false;
    }
    if (!IsKnown(solution)) answer.solutions.push_back(std::move(solution));
    return true;
  }

  void Remember(const IkValues<double, 1>& values, double error2) {
    if (!(error2 < nearest2)) return;
    nearest2 = error2;
    nearest = values;
  }

  void SearchFromSeed() {
    IkValues<double, 1> values = Seed();
    for (int step = 0; step < std::min(kStepsOfSeed, request.max_steps); ++step) {
      const IkValues<double, 1> before = values;
      const IkErrors<double, 1> errors = StepIk(chain, target, values);
      ++answer.steps;
      Remember(before, errors.Total(0));
      if (errors.Total(0) < double{kConverged2} && Accept(values, kMaxRefinements)) return;
    }
  }

  struct Start {
    int steps = 0;
    float reference2 = std::numeric_limits<float>::infinity();
  };

  // Sets a start to the next row of draws.
  void Restart(IkValues<float, kIkStarts>& values, std::size_t k) {
    const std::size_t row = next_draw++ % kDraws;
    while (draws.size() < (row + 1) * count()) {
      draws.push_back(DrawFor(chain.variables[draws.size() % count()], Draw(draws.size())));
    }
    for (std::size_t v = 0; v < count(); ++v) {
      values.of[v * kIkStarts + k] = static_cast<float>(draws[row * count() + v]);
    }
  }

  static IkValues<double, 1> ValuesOf(const IkValues<float, kIkStarts>& all, std::size_t k,
                                      const IkChain& chain) {
    IkValues<double, 1> values;
    for (std::size_t v = 0; v < chain.variables.size(); ++v) {
      const IkVariable& variable = chain.variables[v];
      values.of[v] = std::clamp(double{all.of[v * kIkStarts + k]}, variable.lower, variable.upper);
    }
    return values;
  }

  void SearchFromAllStarts() {
    const IkTarget<float> rounded = RoundedIkTargetOf(request.X_BT);
    IkValues<float, kIkStarts> values;
    std::array<Start, kIkStarts> starts;
    const IkValues<double, 1> seed = Seed();
    for (std::size_t v = 0; v < count(); ++v) {
      values.of[v * kIkStarts] = static_cast<float>(seed.of[v]);
    }
    for (std::size_t k = 1; k < kIkStarts; ++k) Restart(values, k);
    while (answer.steps < request.max_steps) {
      const IkErrors<float, kIkStarts> errors = StepIkStarts(chain, rounded, values);
      ++answer.steps;
      for (std::size_t k = 0; k < kIkStarts; ++k) {
        const float error2 = errors.Total(k);
        const bool converged = error2 < kConverged2;
        if (converged) {
          Accept(ValuesOf(values, k, chain), kMaxRefinements);
          if (is_done()) return;
        }
        if (converged || IsStuck(starts[k], error2)) {
          if (!converged) Remember(ValuesOf(values, k, chain), double{error2});
          starts[k] = {};
          Restart(values, k);
        }
      }
    }
  }

  static bool IsStuck(Start& start, float error2) {
    ++start.steps;
    if (start.steps % kPatience != 0) return false;
    if (start.steps >= kMaxStepsPerStart || !(error2 <= kProgress * start.reference2)) return true;
    start.reference2 = error2;
    return false;
  }

  void Finish() {
    if (answer.solutions.empty()) {
      const IkErrors<double, 1> errors = Refine(nearest, kStepsOfSeed);
      answer.nearest = SolutionOf(nearest, errors);
      // The refinement of values that were nearly there may get there.
      if (IsReached(answer.nearest)) answer.solutions.push_back(answer.nearest);
    }
    const auto distance2 = [&](const PoseSolution& solution) {
      double sum = 0;
      for (std::size_t k = 0; k < solution.row.size(); ++k) {
        sum += (solution.row[k] - request.seed[k]) * (solution.row[k] - request.seed[k]);
      }
      return sum;
    };
    std::ranges::stable_sort(answer.solutions, {}, distance2);
  }
};

PoseAnswer PoseSolver::Solve(const PoseRequest& request) {
  Search search{.chain = chain_, .draws = starts_, .request = request};
  search.nearest = search.Seed();
  if (request.same_branch) {
    search.SearchFromSeed();
  } else {
    search.SearchFromAllStarts();
  }
  search.Finish();
  return std::move(search.answer);
}

}  // namespace cwm::collision
