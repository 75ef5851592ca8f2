// A scene with known ground truth, and the camera that looks at it.
#pragma once

#include <string>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/shape.h"

namespace cwm::perception {

// The role of a part in its object. Graspers look for handles; spouts resemble them.
enum class PieceRole { kBody, kHandle, kSpout };

// Shiny surfaces hide what is behind them and give no return themselves.
enum class Finish { kMatt, kShiny };

struct SimulatedObject {
  std::string name = {};
  std::vector<Placed<>> parts = {};  // in the object's frame, placed by X_FS
  Pose X_WO = Pose::Identity();
  bool is_support = false;
  std::vector<PieceRole> part_roles = {};  // one per part; missing ones are bodies
  Finish finish = Finish::kMatt;

  PieceRole RoleOf(std::size_t part) const {
    return part < part_roles.size() ? part_roles[part] : PieceRole::kBody;
  }
};

// The axis-aligned bounds of all parts, in the world.
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
