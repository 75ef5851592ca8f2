// The pairs of links of a robot that are checked against each other.
#pragma once

#include <vector>

#include "collision/robot/robot_model.h"
#include "collision/robot/srdf.h"

namespace cwm::collision {

// Returns RobotModel::self_pairs. Names that are not links of the model are ignored.
std::vector<LinkPair> SelfPairs(const RobotModel& model, const SemanticDescription* semantic);

}  // namespace cwm::collision
