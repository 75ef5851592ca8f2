// A scene whose truth is known, and the camera that looks at it.
#pragma once

#include <string>
#include <vector>

#include "collision/geometry/shape.h"

namespace cwm::perception {

struct SimulatedObject {
  std::string name;
  std::vector<Placed<>> parts;  // in the object's frame; the last letter of X_FS is the part
  Pose X_WO = Pose::Identity();
  bool is_support = false;
};

struct SimulatedScene {
  std::vector<SimulatedObject> objects;
};

struct PinholeCamera {
  int width = 640;
  int height = 480;
  double focal_px = 525;
  double center_x_px = 319.5;
  double center_y_px = 239.5;
  Pose X_WC = Pose::Identity();  // optical frame: z forward, x right, y down
};

}  // namespace cwm::perception
