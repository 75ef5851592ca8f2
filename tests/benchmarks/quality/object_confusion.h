// The true objects of a simulated scan as labels, and how an interpretation confused them.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/benchmarks/quality/simulated_case.h"

namespace cwm::benchmarks {

// Per point of the scan 0 for what counts nowhere, 1 for supports, 10 (k + 2) for the k-th object of the
// scene. The sides of supports, which are residual geometry, count nowhere. Objects of which few points were measured count nowhere.
std::vector<std::uint32_t> TrueLabelsOf(const SimulatedCase& run);

// The found labels, 0 for objects most of whose points count nowhere.
std::vector<std::uint32_t> CountedLabels(const std::vector<std::uint32_t>& truth,
                                         std::vector<std::uint32_t> found);

struct Confusion {
  int merged = 0;  // true objects that share their found object with another one
  int split = 0;   // true objects of which two found ones hold a fifth each
  std::vector<std::uint32_t> merged_labels = {};  // of the merged ones
};
// One label per point on either side, as of SceneInterpretation::labels.
Confusion ConfusionOf(const std::vector<std::uint32_t>& truth,
                      const std::vector<std::uint32_t>& found);

}  // namespace cwm::benchmarks
