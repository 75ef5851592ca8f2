// The error that all depths of one view share at a small body.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "collision/geometry/shape.h"
#include "perception/cloud/sensor_noise.h"

namespace cwm::perception {

// The points that a sensor shows of a body; both in one frame for all views.
struct BodyView {
  Vector3 sensor = Vector3::Zero();
  std::vector<Eigen::Vector3f> points = {};
};

// True for spheres, boxes, cylinders and cones.
bool HasViewOffsets(const Shape& shape);

// By view, how much too far from its sensor it shows the body, metres along its rays. The slow warp
// of a sensor is nearly constant over a small body, so each view is shifted by an offset of its
// own, and the size of a shape that is fitted to all views errs by their mean. The size and the
// pose of the shape and the offsets are the most likely ones together: the curvature that each view
// shows and the surfaces that several views show determine them. An offset has the standard
// deviation WarpSigma_m; `shape` and `X_FS` are the start of the fit, and are about right. All are
// zero for other shapes than those above, and for sensors without a warp.
//
// The minimum of the robust loss of Geman and McClure (1987), by Gauss and Newton's method.
std::vector<double> ViewOffsets_m(std::span<const BodyView> views, const Shape& shape,
                                  const Pose& X_FS, const SensorNoise& noise);

}  // namespace cwm::perception
