// Medians and other quantiles of unordered values, and samples that tell them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace cwm::perception {

// The value below which about the share `share` (0 to 1) of the values lies: that of rank
// share * (count - 1), rounded down. Zero when there are none.
template <class T>
T Quantile(std::vector<T> values, double share) {
  if (values.empty()) return T(0);
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

// The upper one of the two in the middle where their number is even. Zero when there are none.
template <class T>
T Median(std::vector<T> values) {
  if (values.empty()) return T(0);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// chosen: so many values fix a median to 2 percent of its spread; more tell little more.
inline constexpr std::size_t kSampled = 4096;
// Every how manieth of `count` values makes an even sample of kSampled or a few more. Odd: of the
// pixels of an image all columns take their turns.
inline std::size_t SampleStride(std::size_t count) { return count / kSampled | 1; }

}  // namespace cwm::perception
