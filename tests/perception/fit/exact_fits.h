// The input of fits, made of exact points, for the tests of fits.
#pragma once

#include <numeric>
#include <vector>

#include "perception/fit/shape_fit.h"
#include "tests/perception/search/exact_points.h"

namespace cwm::perception {

// Points seen by a Kinect; all are available until a test takes some away.
struct ExactFits {
  explicit ExactFits(const ExactPoints& exact)
      : points(exact.Model()),
        octree(points),
        connectivity(points),
        available(points.size(), 1),
        all(points.size()) {
    std::iota(all.begin(), all.end(), 0u);
  }

  // From the frame in which the points were made to the frame of the model points, and back.
  Vector3 Local(const Vector3& p) const { return p - points.origin_L; }
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
  FitContext Context() const { return {points, octree, connectivity, noise, options, work}; }

  ModelPoints points;
  Octree octree;
  Connectivity connectivity;
  SensorNoise noise;
  ModelerOptions options;
  Work work;
  std::vector<char> available;
  std::vector<std::uint32_t> all;
};

}  // namespace cwm::perception
