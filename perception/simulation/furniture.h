// Tables, shelves, walls and fronts.
#pragma once

#include <string>

#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// A support: a level plate over an area of the world with its top at the given height.
struct LevelTop {
  Eigen::AlignedBox2d area_W;
  double top_m = 0;
  double thickness_m = 0.03;
};
SimulatedObject MakeTop(std::string name, const LevelTop& top);

// A box along the world's axes that is not a support.
SimulatedObject MakeBlock(std::string name, const Aabb& bounds_W);

}  // namespace cwm::perception
