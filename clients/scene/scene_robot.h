// What a planning scene says of a robot, as changes of a world that holds the robot.
#pragma once

#include <string>
#include <vector>

#include "clients/formats/scene_file.h"
#include "cwm/v1/world.pb.h"

namespace cwm::scene {

// "a, b, c" of the first five, printable, "and 4 more" of the rest.
std::string Listed(const std::vector<std::string>& names);

bool HasLink(const cwm::v1::Robot& robot, const std::string& link);

struct SceneState {
  cwm::v1::SetRobotState set;
  bool sets_base = false;
  std::vector<std::string> warnings;  // what was left out, and why
};

// A joint of several degrees of freedom that the robot does not have is the virtual joint by which
// it stands in the world: the pose of its base. Left out are fixed joints, which have no value,
// joints that follow others, and joints that the robot does not have; all with a warning but a
// fixed joint at 0, which begin with the name of the field.
SceneState StateOf(const formats::SceneRobotState& state, const cwm::v1::Robot& robot,
                   const std::string& field = "robot_state");

struct SceneRules {
  std::vector<cwm::v1::NamedPair> pairs;
  std::vector<cwm::v1::NamedPair> withdrawn;
  std::vector<std::string> warnings;
};

// The pairs that may collide, each once. A name is that of a link of the robot (nullptr: there is
// none) or of an object of the scene; others are left out with a warning. What may by default touch
// everything is allowed with "*", or, where the matrix makes exceptions, with each thing of the
// scene that it may touch. Withdrawn is what `before`, rules of the world, allows and the matrix says
// false to; it says nothing of pairs that it does not have. Where the matrix and the robot differ about
// pairs of its links, a warning says so.
SceneRules RulesOf(const formats::SceneFile& scene, const cwm::v1::Robot* robot,
                   const std::vector<cwm::v1::PairRule>& before = {});

}  // namespace cwm::scene
