// By how much a found shape differs from the true one, quantity by quantity.
#pragma once

#include <optional>
#include <vector>

#include "tests/benchmarks/quality/seen_shapes.h"

namespace cwm::benchmarks {

// What is not determined for a pair of kinds, or was not seen, is absent. Infinite where the found
// shape has no such quantity at all.
struct ShapeErrors {
  // Spheres; cylinders and cones at the height of the middle of what was seen.
  std::optional<double> radius_m;
  std::optional<double> axis_rad;        // cylinders and cones, whichever way the axes point
  std::optional<double> half_angle_rad;  // of true cones; a cylinder's is 0
  std::vector<double> length_m;        // of cylinders and cones, and edges of boxes: both ends seen
  std::optional<double> box_axis_rad;  // largest of the angles between the edges' directions
  // Between the centres, without the directions whose two ends were not both seen.
  std::optional<double> centre_m;
};

// A length is measured where both of its ends are: points within three pixels of each, ten of them
// (an end that fewer show is a mixed pixel or two).
inline constexpr double kEndSeen_px = 3;
inline constexpr int kEndSeenPoints = 10;

ShapeErrors ErrorsOf(const TrueShape& truth, const FoundShape& found, const InterpretedView& view);

// Each quantity that a perfect answer would have an error of zero for, infinite: what a shape that
// was not found is counted with.
ShapeErrors InfiniteErrors(const TrueShape& truth, const InterpretedView& view);

// The radius of a sphere, or of a cylinder or cone at height z of its frame.
std::optional<double> RadiusAt_m(const Shape& shape, double z_m);

// The mean of the points measured on it, on its surface, in its own frame. It has points.
Vector3 MiddleOfSeen_S(const TrueShape& truth, const InterpretedView& view);

// Root mean square of the distances to the found shape's surface from where, on the true surface,
// the points were measured. Metres. The true shape has points.
double SurfaceDifference_m(const TrueShape& truth, const FoundShape& found,
                           const InterpretedView& view);

}  // namespace cwm::benchmarks
