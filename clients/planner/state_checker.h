// The interface for checking many states at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"

namespace cwm::planner {

// The number of checks made.
struct CheckCounts {
  std::int64_t batches = 0;
  std::int64_t states = 0;
};

class StateChecker {
 public:
  virtual ~StateChecker() = default;

  // One byte for each row of `rows`, which have one number per joint: 1 if the state is free.
  // Without rows there is no query.
  absl::StatusOr<std::vector<std::uint8_t>> CheckStates(std::span<const double> rows,
                                                        std::size_t width) {
    if (rows.empty()) return std::vector<std::uint8_t>();
    ++counts_.batches;
    counts_.states += static_cast<std::int64_t>(rows.size() / width);
    return Evaluate(rows, width);
  }

  const CheckCounts& counts() const { return counts_; }

 private:
  virtual absl::StatusOr<std::vector<std::uint8_t>> Evaluate(std::span<const double> rows,
                                                             std::size_t width) = 0;

  CheckCounts counts_;
};

}  // namespace cwm::planner
