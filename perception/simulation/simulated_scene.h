// A scene whose truth is known, and the camera that looks at it.
#pragma once

#include <string>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/shape.h"

namespace cwm::perception {

// What a part is to its object. Handles are what graspers look for; spouts resemble them.
enum class PieceRole { kBody, kHandle, kSpout };

// Shiny surfaces hide what is behind them and return nothing themselves.
enum class Finish { kMatt, kShiny };

struct SimulatedObject {
  std::string name = {};
  std::vector<Placed<>> parts = {};  // in the object's frame; the last letter of X_FS is the part
  Pose X_WO = Pose::Identity();
  bool is_support = false;
  std::vector<PieceRole> part_roles =
      {};  // of the parts in their order; bodies where it is shorter
  Finish finish = Finish::kMatt;

  PieceRole RoleOf(std::size_t part) const {
    return part < part_roles.size() ? part_roles[part] : PieceRole::kBody;
  }
};

// The axis-aligned bounds in the world, all parts.
Aabb BoundsInWorld(const SimulatedObject& object);

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
