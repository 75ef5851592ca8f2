// How a sensor's image lies in the frame of its points.
#pragma once

#include "perception/cloud/measured_points.h"

namespace cwm::perception {

// The axes of the sensor's frame that an image looks along and that its rows count against, told by
// its rays: z and -y of an optical frame, x and z of a body's.
struct ImageAxes {
  Vector3 forward = Vector3::UnitZ();
  Vector3 up = -Vector3::UnitY();
  bool is_all_around = false;  // no camera's
};

// In the frame that the points are in. An optical frame's where the rays do not tell. An image all
// around looks along x, or along z where x is up.
ImageAxes AxesOf(const MeasuredPoints& image);

}  // namespace cwm::perception
