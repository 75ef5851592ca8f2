// The input of fits, made of exact points, for the tests of fits.
#pragma once

#include <numeric>
#include <vector>

#include "tests/perception/fit/fit_input.h"
#include "tests/perception/search/exact_points.h"

namespace cwm::perception {

// Points seen by a Kinect; all are available until a test takes some away.
struct ExactFits : FitInput {
  explicit ExactFits(const ExactPoints& exact)
      : FitInput(exact.Model()), available(points.size(), 1), all(points.size()) {
    std::iota(all.begin(), all.end(), 0u);
  }

  // The inverse of Local.
  Vector3 Made(const Vector3& p) const { return p + points.origin_L; }
  // The number of listed points for which `holds` is true, given their position in the frame in
  // which they were made.
  template <class Holds>
  std::size_t CountOf(const std::vector<std::uint32_t>& listed, const Holds& holds) const {
    std::size_t count = 0;
    for (std::uint32_t i : listed) count += holds(Made(points.p[i])) ? 1 : 0;
    return count;
  }
  // Makes the points for which `holds` is true unavailable.
  template <class Holds>
  void TakeAway(const Holds& holds) {
    for (std::uint32_t i : all) {
      if (holds(Made(points.p[i]))) available[i] = 0;
    }
  }

  std::vector<char> available;
  std::vector<std::uint32_t> all;
};

}  // namespace cwm::perception
