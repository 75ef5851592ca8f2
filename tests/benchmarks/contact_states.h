// Difficult states of the Panda: half of them in collision, a quarter next to contact.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/benchmarks/panda_problems.h"

namespace cwm::benchmarks {

// No point of the arm moves farther than this between such a state and one at which the verdict
// changes, so no gap or overlap there is wider.
inline constexpr double kNextToContact_m = 5e-3;

struct ContactStates {
  std::vector<double> rows;           // of the arm, row by row
  std::vector<std::uint8_t> is_near;  // next to contact; one per row
};

// About `count` states for one problem, from RandomStates and the exact engine's verdicts. Three
// quarters of them are half free and half in collision, as far as the problem has so many. The rest
// lie on lines in joint space from a free state to one in collision, which are bisected to the
// change of verdict; the state is a random share of kNextToContact_m away from it, on either side.
ContactStates StatesAboutContact(const PandaProblems& all, const PandaProblem& problem,
                                 std::size_t count, std::uint64_t seed);

}  // namespace cwm::benchmarks
