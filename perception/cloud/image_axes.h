// The orientation of a sensor's image in the frame of its points.
#pragma once

#include "perception/cloud/measured_points.h"

namespace cwm::perception {

// The axes of the sensor's frame along which an image looks, and against which its rows count. They
// follow from the rays: z and -y of an optical frame, x and z of a body frame.
struct ImageAxes {
  Vector3 forward = Vector3::UnitZ();
  Vector3 up = -Vector3::UnitY();
  bool is_all_around = false;  // no camera's image
};

// derived: the mean ray of a camera of up to 120 degrees is longer than this; that of a scan all
// around vanishes.
inline constexpr float kMinMeanRay = 0.5f;

// The coordinate axis, or its opposite, nearest to a direction.
Vector3 NearestAxis(const Eigen::Vector3f& direction);

// Returns the axes in the frame of the points; those of an optical frame if the rays do not
// determine them. An image all around looks along x, or along z if x is up.
ImageAxes AxesOf(const MeasuredPoints& image);

}  // namespace cwm::perception
