// Converts a planning scene's data about a robot to changes of a world that has the robot.
#pragma once

#include <string>
#include <vector>

#include "clients/formats/scene_file.h"
#include "cwm/v1/world.pb.h"

namespace cwm::scene {

// "a, b, c and 4 more": the first five names, made printable.
std::string FormatNames(const std::vector<std::string>& names);

bool HasLink(const cwm::v1::Robot& robot, const std::string& link);

struct SceneState {
  cwm::v1::SetRobotState set;
  bool sets_base = false;
  std::vector<std::string> warnings;  // what was ignored, and why
};

// A joint with several degrees of freedom that the robot does not have is the virtual joint that
// connects it to the world: it sets the base's pose. Ignored are fixed joints, which have no value,
// joints that follow others, and unknown joints; all with a warning except a fixed joint at 0.
// Warnings begin with the field's name.
SceneState ConvertRobotState(const formats::SceneRobotState& state, const cwm::v1::Robot& robot,
                             const std::string& field = "robot_state");

struct SceneRules {
  std::vector<cwm::v1::NamedPair> pairs;    // that may collide
  std::vector<cwm::v1::NamedPair> checked;  // of links, which the robot does not check by itself
  std::vector<cwm::v1::NamedPair> withdrawn;
  std::vector<std::string> warnings;
};

// The pairs that may collide, each once. A name is that of a link of the robot (nullptr: no robot)
// or of an object of the scene; others are ignored with a warning. A name that may touch everything
// by default is allowed with "*" or, if the matrix makes exceptions, with each object or link of
// the scene that it may touch. `withdrawn` has the pairs that `before`, the world's rules, allows
// and for which the matrix says false; pairs that it does not have are unaffected. `checked` has
// the pairs of links for which the matrix says false and which the robot does not check. Warnings
// report pairs of links for which the matrix and the robot disagree.
SceneRules ConvertRules(const formats::SceneFile& scene, const cwm::v1::Robot* robot,
                        const std::vector<cwm::v1::PairRule>& before = {});

}  // namespace cwm::scene
