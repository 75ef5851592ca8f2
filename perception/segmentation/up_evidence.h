// Evidence for the directions that may be up.
#pragma once

#include <cstddef>
#include <vector>

#include "perception/cloud/image_axes.h"
#include "perception/segmentation/support_planes.h"

namespace cwm::perception {

// The evidence for a direction `up`, a unit vector: the normal of a large plane, or its opposite.
struct UpEvidence {
  Vector3 up = Vector3::UnitZ();
  double facing_share = 0;      // of all cells: on large planes that face up, as supports do
  double hanging_share = 0;     // on large planes that face down, as ceilings do
  std::size_t thing_cells = 0;  // of things that stand on the planes that face up
  // The share of loose cells, on no large plane, in connected sets whose lowest end lies on a surface
  // that faces up: things rest, and do not float.
  double resting_share = 0;
  double image_cos = 0;    // cosine of the angle between up and the image's up
  double forward_cos = 0;  // and the axis along which the sensor looks

  // Natural, up to a constant that all directions share.
  double LogOdds() const;
};

// The directions along the normals of large planes, likeliest first. `axes` are those of the image,
// or of the convention that a list of points shows (AxesOfList).
std::vector<UpEvidence> WeighUps(const CoarseCloud& coarse, const ImageAxes& axes);

// The axes of an image that a list of points shows by where it lies: before the sensor along z
// (optical, y down), along -z (viewer, y up) or along x (body, z up). `up` is zero if it lies along
// another axis; z is up, and `forward` is zero, if it lies all around.
ImageAxes AxesOfList(const OrientedPoints& points);

}  // namespace cwm::perception
