// Medians and other quantiles of unordered values, and sample sizes for them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace cwm::perception {

// The value below which about the share `share` (0 to 1) of the values lies: that of rank share *
// (count - 1), rounded down. Zero if there are none.
template <class T>
T Quantile(std::vector<T> values, double share) {
  if (values.empty()) return T(0);
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

// The median; the upper one of the two middle values if their number is even. Zero if there are
// none.
template <class T>
T Median(std::vector<T> values) {
  if (values.empty()) return T(0);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// chosen: this many values determine a median to 2 percent of its spread; more add little.
inline constexpr std::size_t kMaxQuantileSamples = 4096;
// The stride that takes an even sample of kMaxQuantileSamples of `count` values, or a few more. It
// is odd, so that the sample of an image's pixels visits all columns.
inline std::size_t SampleStride(std::size_t count) { return count / kMaxQuantileSamples | 1; }

}  // namespace cwm::perception
