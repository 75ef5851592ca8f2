// Checks states with a server, at one revision of the world.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clients/planner/state_checker.h"
#include "clients/planner/state_query.h"

namespace cwm::planner {

// A state is free if its verdict is FREE.
class ServerChecker : public StateChecker {
 public:
  explicit ServerChecker(StateQuery query);

 private:
  absl::StatusOr<std::vector<std::uint8_t>> Evaluate(std::span<const double> rows,
                                                     std::size_t width) override;

  StateQuery query_;
};

}  // namespace cwm::planner
