#include "tests/benchmarks/state_draws.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace cwm::benchmarks {

using collision::Variable;

double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / std::max<double>(1, static_cast<double>(values.size()));
}

std::vector<double> StateDraws::Next() {
  std::vector<double> row;
  for (const int v : group_.variables) {
    const Variable& variable = model_.variables[static_cast<std::size_t>(v)];
    const bool is_endless = std::isinf(variable.lower) || std::isinf(variable.upper);
    row.push_back(is_endless ? Between(-std::numbers::pi, std::numbers::pi)
                             : Between(variable.lower, variable.upper));
  }
  return row;
}

std::vector<double> StateDraws::OneRadianFrom(const std::vector<double>& from) {
  std::normal_distribution<double> normal;
  std::vector<double> to = from;
  double length = 0;
  for (double& value : to) {
    const double step = normal(random_);
    value = step;
    length += step * step;
  }
  for (std::size_t k = 0; k < to.size(); ++k) {
    const Variable& variable = model_.variables[static_cast<std::size_t>(group_.variables[k])];
    to[k] = std::clamp(from[k] + to[k] / std::sqrt(length), variable.lower, variable.upper);
  }
  return to;
}

double StateDraws::Between(double lower, double upper) {
  return std::uniform_real_distribution<double>(lower, upper)(random_);
}

}  // namespace cwm::benchmarks
