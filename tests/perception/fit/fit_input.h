// The input of fits, for tests: points as they are searched, and the rest as by default.
#pragma once

#include <utility>

#include "perception/fit/shape_fit.h"

namespace cwm::perception {

struct FitInput {
  explicit FitInput(ModelPoints made)
      : points(std::move(made)), octree(points), connectivity(points) {}

  // From the frame in which the points were made to the frame of the model points.
  Vector3 Local(const Vector3& p) const { return p - points.origin_L; }
  FitContext Context(const Ground& ground = {}) const {
    return {points, octree, connectivity, noise, options, work, ground};
  }

  ModelPoints points;
  Octree octree;
  Connectivity connectivity;
  SensorNoise noise;
  ModelerOptions options;
  Work work;
};

}  // namespace cwm::perception
