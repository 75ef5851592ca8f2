// The interface for checking many states at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"

namespace cwm::planner {

// The number of checks made.
struct Asked {
  std::int64_t batches = 0;
  std::int64_t states = 0;
};

class StateChecker {
 public:
  virtual ~StateChecker() = default;

  // One byte for each row of `rows`, which have one number per joint: 1 if the state is free.
  // Without rows there is no query.
  absl::StatusOr<std::vector<std::uint8_t>> AreFree(std::span<const double> rows,
                                                    std::size_t width) {
    if (rows.empty()) return std::vector<std::uint8_t>();
    ++asked_.batches;
    asked_.states += static_cast<std::int64_t>(rows.size() / width);
    return Answer(rows, width);
  }

  const Asked& asked() const { return asked_; }

 private:
  virtual absl::StatusOr<std::vector<std::uint8_t>> Answer(std::span<const double> rows,
                                                           std::size_t width) = 0;

  Asked asked_;
};

}  // namespace cwm::planner
