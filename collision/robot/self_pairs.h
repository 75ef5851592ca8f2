// Which links of a robot are checked against each other.
#pragma once

#include <vector>

#include "collision/robot/robot_model.h"
#include "collision/robot/srdf.h"

namespace cwm::collision {

// As RobotModel::self_pairs says. Names that the links do not have are passed over.
std::vector<LinkPair> SelfPairs(const RobotModel& model, const SemanticDescription* semantic);

}  // namespace cwm::collision
