// Sorting that can be interrupted: std::sort of many millions of values takes seconds in one step.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "collision/geometry/work_counter.h"

namespace cwm {

// Number of values that are sorted by one call of std::sort before they are merged.
inline constexpr std::size_t kSortBlockSize = std::size_t{1} << 15;

// Sorts like std::sort: blocks of kSortBlockSize values, then merges. Polls `work` at least every
// few milliseconds; if that ends it, the order of the values is undefined.
template <class T, class Before>
void InterruptibleSort(std::vector<T>& values, const Before& before, WorkCounter* work = nullptr) {
  constexpr std::size_t kStepsPerCompare = 1;
  constexpr std::size_t kMergeBlockSize = std::size_t{1} << 14;
  const auto at = [](std::vector<T>& v, std::size_t i) {
    return v.begin() + static_cast<std::ptrdiff_t>(i);
  };
  const std::size_t size = values.size();
  for (std::size_t first = 0; first < size; first += kSortBlockSize) {
    const std::size_t last = std::min(size, first + kSortBlockSize);
    std::sort(at(values, first), at(values, last), before);
    if (MustEnd(work, kStepsPerCompare * 2 * (last - first))) return;
  }
  if (size <= kSortBlockSize) return;
  std::vector<T> merged;
  for (std::size_t width = kSortBlockSize; width < size; width *= 2) {
    merged.clear();
    merged.reserve(size);
    for (std::size_t first = 0; first < size; first += 2 * width) {
      std::size_t a = first, b = std::min(size, first + width);
      const std::size_t end_a = b, end_b = std::min(size, b + width);
      while (a < end_a || b < end_b) {
        const std::size_t stop = std::min(merged.size() + kMergeBlockSize, size);
        while (merged.size() < stop && a < end_a && b < end_b) {
          merged.push_back(before(values[b], values[a]) ? values[b++] : values[a++]);
        }
        while (merged.size() < stop && a < end_a && b == end_b) merged.push_back(values[a++]);
        while (merged.size() < stop && b < end_b && a == end_a) merged.push_back(values[b++]);
        if (MustEnd(work, kMergeBlockSize)) return;
      }
    }
    values.swap(merged);
  }
}

}  // namespace cwm
