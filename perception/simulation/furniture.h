// Tables, shelves, walls and fronts.
#pragma once

#include <string>

#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// A support: a level plate over an area of the world, its top at that height.
struct LevelTop {
  Eigen::AlignedBox2d area_W;
  double top_m = 0;
  double thickness_m = 0.03;
};
SimulatedObject MakeTop(std::string name, const LevelTop& top);

// A box along the axes of the world that supports nothing.
SimulatedObject MakeBlock(std::string name, const Aabb& bounds_W);

}  // namespace cwm::perception
