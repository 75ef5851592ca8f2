// The true objects of a simulated scan as labels, and how an interpretation confused them.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/benchmarks/quality/simulated_case.h"

namespace cwm::benchmarks {

// Per point of the scan: 0 for points that are not counted, 1 for supports, 10 (k + 2) for the k-th
// object of the scene. Not counted are the sides of supports, which are residual geometry, and
// objects with few measured points.
std::vector<std::uint32_t> TrueLabelsOf(const SimulatedCase& run);

// The found labels, with 0 for objects most of whose points are not counted.
std::vector<std::uint32_t> CountedLabels(const std::vector<std::uint32_t>& truth,
                                         std::vector<std::uint32_t> found);

struct Confusion {
  int merged = 0;  // true objects that share their found object with another one
  int split = 0;   // true objects of which two found ones have a fifth each
  std::vector<std::uint32_t> merged_labels = {};  // of the merged ones
};
// Takes one label per point on either side, as in SceneInterpretation::labels.
Confusion ConfusionOf(const std::vector<std::uint32_t>& truth,
                      const std::vector<std::uint32_t>& found);

}  // namespace cwm::benchmarks
