// Who says whether states are free: asked about many at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"

namespace cwm::planner {

// What was asked so far.
struct Asked {
  std::int64_t batches = 0;
  std::int64_t states = 0;
};

class StateChecker {
 public:
  virtual ~StateChecker() = default;

  // One byte for each row of `rows`, which hold one number a joint: 1 where the state is free. No
  // rows: no question.
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
