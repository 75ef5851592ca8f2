// The difference between a found shape and the true one, quantity by quantity.
#pragma once

#include <optional>
#include <vector>

#include "tests/benchmarks/quality/seen_shapes.h"

namespace cwm::benchmarks {

// A quantity is absent if it is not determined for the pair of kinds or was not seen, and infinite
// if the found shape has no such quantity at all.
struct ShapeErrors {
  // Radius of spheres; of cylinders and cones at the height of the middle of the visible part.
  std::optional<double> radius_m;
  std::optional<double> axis_rad;        // of cylinders and cones, either way
  std::optional<double> half_angle_rad;  // of true cones; a cylinder's is 0
  std::vector<double> length_m;        // of cylinders and cones, and edges of boxes: both ends seen
  std::optional<double> box_axis_rad;  // largest of the angles between the edges' directions
  // Between the centres, without the directions in which an end was not seen.
  std::optional<double> centre_m;
};

// A length counts as measured if both of its ends are: ten points within three pixels of each (an
// end with fewer points is a mixed pixel or two).
inline constexpr double kEndSeen_px = 3;
inline constexpr int kEndSeenPoints = 10;

ShapeErrors ErrorsOf(const TrueShape& truth, const FoundShape& found, const InterpretedView& view);

// The errors of a shape that was not found: infinite for each quantity that a perfect answer would
// have.
ShapeErrors InfiniteErrors(const TrueShape& truth, const InterpretedView& view);

// The radius of a sphere, or of a cylinder or cone at height z of its frame.
std::optional<double> RadiusAt_m(const Shape& shape, double z_m);

// The mean of the points measured on the shape, moved onto its surface, in its own frame. The shape
// has points.
Vector3 MiddleOfSeen_S(const TrueShape& truth, const InterpretedView& view);

// Root mean square distance, in metres, of the found shape's surface from the positions on the true
// surface at which the points were measured. The true shape has points.
double SurfaceDifference_m(const TrueShape& truth, const FoundShape& found,
                           const InterpretedView& view);

}  // namespace cwm::benchmarks
