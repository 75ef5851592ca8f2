// Surfaces of revolution about a vertical axis, seen from above: vessels, inside and outside.
#pragma once

#include <optional>
#include <span>

#include "perception/cloud/oriented_points.h"
#include "perception/segmentation/plane_fit.h"

namespace cwm::perception {

// A vertical axis that the horizontal parts of the normals pass.
struct Revolution {
  Vector2 axis = Vector2::Zero();  // in the level frame, metres
  double radius_m = 0;             // 90th percentile of the distance to the axis
  double agreement = 0;  // share of the steep members whose normals pass through the axis, 0..1
  double outward = 0;    // share of those that point away from the axis: 1 outside, 0 inside
  double steep = 0;      // share of all members with steep normals
};

// Fits an axis to the normals. Empty if they do not fan out enough to determine it, or if too few
// of them (20) are steep.
std::optional<Revolution> FitRevolution(const OrientedPoints& points,
                                        std::span<const std::uint32_t> members);

// Returns how well the members agree with the given axis, which is not refitted.
Revolution EvaluateRevolution(const OrientedPoints& points, std::span<const std::uint32_t> members,
                              const Vector2& axis);

}  // namespace cwm::perception
