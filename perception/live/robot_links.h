// The links of the robots in a world at a frame's stamp, for what moves with them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "perception/live/robot_surface.h"
#include "perception/live/robot_view.h"

namespace cwm::perception {

// The links of a robot in an order in which parents come before children.
struct LinkTree {
  std::vector<std::string> names = {};
  std::vector<int> parents = {};  // -1 for the root
};

struct RobotLinks {
  std::string robot = {};
  std::shared_ptr<const LinkTree> tree = {};         // not null
  std::shared_ptr<const RobotSurface> surface = {};  // not null; one surface per link
  std::vector<LinkAtStamp> links = {};               // one per link
};

}  // namespace cwm::perception
