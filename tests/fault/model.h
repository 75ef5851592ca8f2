// A world as the checker folds it: few values, all of them exact integers, and what each change
// does to them.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace cwm::fault {

// A position in steps of 1/1024 m, which a double holds exactly, so that sums of positions are
// exact as well.
using Place = std::array<std::int64_t, 3>;
inline constexpr double kStepsPerMetre = 1024.0;

struct ModelObject {
  Place place = {};
  std::string geometry = {};     // a text that names the shape, see messages.h
  std::string attached_to = {};  // "robot/link"; empty: not attached
  bool operator==(const ModelObject&) const = default;
};

// A robot whose one joint moves the link "plate" along x.
struct ModelRobot {
  std::int64_t joint = 0;  // 1/1024 m
  bool operator==(const ModelRobot&) const = default;
};

struct ModelRule {
  bool allowed = false;
  std::optional<std::int64_t> margin = {};  // 1/1024 m
  bool operator==(const ModelRule&) const = default;
};

struct ModelWorld {
  std::map<std::string, ModelObject> objects = {};
  std::map<std::string, ModelRobot> robots = {};
  std::map<std::string, ModelRule> rules = {};  // by the two names "a|b" in their order
  bool operator==(const ModelWorld&) const = default;
};

struct Change {
  enum class Kind {
    kPut,
    kMove,
    kRemove,
    kRobotState,
    kAllow,
    kMargin,
    kAttach,
    kDetach,
    kLoadRobot,
    kDeleteRobot,
  };
  Kind kind = Kind::kPut;
  std::string name = {};
  std::string other = {};     // kAllow, kMargin: the second name; kAttach: the robot
  Place place = {};           // kPut, kMove
  std::string geometry = {};  // kPut
  // kRobotState: the joint, 1/1024 m. kAllow: 1 allows, 0 withdraws. kMargin: 1/1024 m; -1 removes.
  std::int64_t value = 0;
  bool operator==(const Change&) const = default;
};

// The key of ModelWorld::rules.
std::string RuleKey(const std::string& a, const std::string& b);

// The world after all changes; empty if one of them cannot be applied.
std::optional<ModelWorld> Apply(const ModelWorld& world, const std::vector<Change>& changes);

// True if a power cut may take the write: it sets states of robots and nothing else.
bool IsObserved(const std::vector<Change>& changes);

// What a message of a watch says of one thing of the world.
struct Effect {
  enum class Kind { kObject, kMove, kRemoveObject, kRobot, kRobotState, kRemoveRobot, kRule };
  Kind kind = Kind::kObject;
  std::string name = {};
  ModelObject object = {};  // kMove: the place alone
  ModelRobot robot = {};
  ModelRule rule = {};  // one that allows nothing and has no margin was removed
};

// False if the effect is about something that the world does not have.
bool ApplyEffect(const Effect& effect, ModelWorld& world);

struct ModelHash {
  std::uint64_t objects = 0;
  std::uint64_t robots = 0;
  std::uint64_t rules = 0;
  bool operator==(const ModelHash&) const = default;
};
ModelHash HashOf(const ModelWorld& world);

// The world on one line, for reports.
std::string TextOf(const ModelWorld& world);

void to_json(nlohmann::json& json, const Change& change);
void from_json(const nlohmann::json& json, Change& change);
void to_json(nlohmann::json& json, const Effect& effect);
void from_json(const nlohmann::json& json, Effect& effect);

}  // namespace cwm::fault
