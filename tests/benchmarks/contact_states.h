// States of the Panda that hurt: half of them in collision, a quarter next to contact.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/benchmarks/panda_problems.h"

namespace cwm::benchmarks {

// No point of the arm moves farther between such a state and one at which the verdict changes, so
// that no gap or overlap there is wider.
inline constexpr double kNextToContact_m = 5e-3;

struct ContactStates {
  std::vector<double> rows;           // of the arm, row by row
  std::vector<std::uint8_t> is_near;  // next to contact; one a row
};

// About `count` states for one problem, from RandomStates and the exact engine's verdicts: of three
// quarters of them half free and half in collision, as far as the problem has so many; the rest on
// lines in joint space from a free state to one in collision, bisected until the change of verdict
// is found and then left by a random share of kNextToContact_m, to either side.
ContactStates StatesAboutContact(const PandaProblems& all, const PandaProblem& problem,
                                 std::size_t count, std::uint64_t seed);

}  // namespace cwm::benchmarks
