#include "tests/fault/model.h"

#include <algorithm>
#include <string_view>

namespace cwm::fault {
namespace {

// FNV-1a of 64 bits.
class Fnv {
 public:
  void Add(std::string_view text) {
    for (const char c : text) AddByte(static_cast<unsigned char>(c));
    AddByte(0xff);  // ends the text: it is no byte of UTF-8
  }
  void Add(std::int64_t number) {
    for (int shift = 0; shift < 64; shift += 8) {
      AddByte(static_cast<unsigned char>(static_cast<std::uint64_t>(number) >> shift));
    }
  }
  std::uint64_t value() const { return value_; }

 private:
  void AddByte(unsigned char byte) { value_ = (value_ ^ byte) * 1'099'511'628'211U; }
  std::uint64_t value_ = 14'695'981'039'346'656'037U;
};

void DropEmptyRule(const std::string& key, ModelWorld& world) {
  const auto rule = world.rules.find(key);
  if (rule != world.rules.end() && rule->second == ModelRule{}) world.rules.erase(rule);
}

void DetachAll(const std::string& robot, ModelWorld& world) {
  for (auto& [name, object] : world.objects) {
    if (object.attached_to.starts_with(robot + "/")) object.attached_to.clear();
  }
}

void MoveJoint(const std::string& robot, std::int64_t joint, ModelWorld& world) {
  const std::int64_t step = joint - world.robots.at(robot).joint;
  world.robots.at(robot).joint = joint;
  for (auto& [name, object] : world.objects) {
    if (object.attached_to == robot + "/plate") object.place[0] += step;
  }
}

// The changes of objects.
bool ApplyToObject(const Change& change, ModelWorld& world) {
  if (change.kind == Change::Kind::kPut) {
    if (world.robots.contains(change.name)) return false;
    world.objects[change.name] = {.place = change.place, .geometry = change.geometry};
    return true;
  }
  const auto object = world.objects.find(change.name);
  if (object == world.objects.end()) return false;
  switch (change.kind) {
    case Change::Kind::kMove:
      object->second.place = change.place;
      object->second.attached_to.clear();
      return true;
    case Change::Kind::kRemove:
      world.objects.erase(object);
      return true;
    case Change::Kind::kAttach:
      if (!world.robots.contains(change.other)) return false;
      object->second.attached_to = change.other + "/plate";
      return true;
    default:  // kDetach
      object->second.attached_to.clear();
      return true;
  }
}

bool ApplyOne(const Change& change, ModelWorld& world) {
  switch (change.kind) {
    case Change::Kind::kRobotState:
      if (!world.robots.contains(change.name)) return false;
      MoveJoint(change.name, change.value, world);
      return true;
    case Change::Kind::kLoadRobot:
      if (world.objects.contains(change.name)) return false;
      if (!world.robots.contains(change.name)) world.robots[change.name] = {};
      return true;
    case Change::Kind::kDeleteRobot:
      if (world.robots.erase(change.name) == 0) return false;
      DetachAll(change.name, world);
      return true;
    case Change::Kind::kAllow: {
      const std::string key = RuleKey(change.name, change.other);
      world.rules[key].allowed = change.value != 0;
      DropEmptyRule(key, world);
      return true;
    }
    case Change::Kind::kMargin: {
      const std::string key = RuleKey(change.name, change.other);
      world.rules[key].margin.reset();
      if (change.value >= 0) world.rules[key].margin = change.value;
      DropEmptyRule(key, world);
      return true;
    }
    default:
      return ApplyToObject(change, world);
  }
}

}  // namespace

std::string RuleKey(const std::string& a, const std::string& b) {
  return std::min(a, b) + "|" + std::max(a, b);
}

std::optional<ModelWorld> Apply(const ModelWorld& world, const std::vector<Change>& changes) {
  ModelWorld after = world;
  for (const Change& change : changes) {
    if (!ApplyOne(change, after)) return std::nullopt;
  }
  return after;
}

bool IsObserved(const std::vector<Change>& changes) {
  return !changes.empty() && std::all_of(changes.begin(), changes.end(), [](const Change& change) {
    return change.kind == Change::Kind::kRobotState;
  });
}

bool ApplyEffect(const Effect& effect, ModelWorld& world) {
  switch (effect.kind) {
    case Effect::Kind::kObject:
      world.objects[effect.name] = effect.object;
      return true;
    case Effect::Kind::kMove: {
      const auto object = world.objects.find(effect.name);
      if (object == world.objects.end()) return false;
      object->second.place = effect.object.place;
      return true;
    }
    case Effect::Kind::kRemoveObject:
      return world.objects.erase(effect.name) == 1;
    case Effect::Kind::kRobot:
      world.robots[effect.name] = effect.robot;
      return true;
    case Effect::Kind::kRobotState: {
      const auto robot = world.robots.find(effect.name);
      if (robot == world.robots.end()) return false;
      robot->second = effect.robot;
      return true;
    }
    case Effect::Kind::kRemoveRobot:
      return world.robots.erase(effect.name) == 1;
    case Effect::Kind::kRule:
      world.rules[effect.name] = effect.rule;
      DropEmptyRule(effect.name, world);
      return true;
  }
  return false;
}

ModelHash HashOf(const ModelWorld& world) {
  Fnv objects;
  for (const auto& [name, object] : world.objects) {
    objects.Add(name);
    for (const std::int64_t x : object.place) objects.Add(x);
    objects.Add(object.geometry);
    objects.Add(object.attached_to);
  }
  Fnv robots;
  for (const auto& [name, robot] : world.robots) {
    robots.Add(name);
    robots.Add(robot.joint);
  }
  Fnv rules;
  for (const auto& [key, rule] : world.rules) {
    rules.Add(key);
    rules.Add(std::int64_t{rule.allowed});
    rules.Add(rule.margin.value_or(-1));
  }
  return {.objects = objects.value(), .robots = robots.value(), .rules = rules.value()};
}

std::string TextOf(const ModelWorld& world) {
  std::string text;
  for (const auto& [name, object] : world.objects) {
    text += name + "@" + std::to_string(object.place[0]) + "," + std::to_string(object.place[1]) +
            "," + std::to_string(object.place[2]) + " " + object.geometry.substr(0, 16) +
            (object.attached_to.empty() ? "" : " on " + object.attached_to) + "; ";
  }
  for (const auto& [name, robot] : world.robots) {
    text += name + "=" + std::to_string(robot.joint) + "; ";
  }
  for (const auto& [key, rule] : world.rules) {
    text += key + (rule.allowed ? " allowed" : "") +
            (rule.margin ? " margin " + std::to_string(*rule.margin) : "") + "; ";
  }
  return text;
}

void to_json(nlohmann::json& json, const Change& change) {
  json = {static_cast<int>(change.kind),
          change.name,
          change.other,
          change.place,
          change.geometry,
          change.value};
}

void from_json(const nlohmann::json& json, Change& change) {
  change.kind = static_cast<Change::Kind>(json.at(0).get<int>());
  json.at(1).get_to(change.name);
  json.at(2).get_to(change.other);
  json.at(3).get_to(change.place);
  json.at(4).get_to(change.geometry);
  json.at(5).get_to(change.value);
}

void to_json(nlohmann::json& json, const Effect& effect) {
  json = {static_cast<int>(effect.kind), effect.name,
          effect.object.place,           effect.object.geometry,
          effect.object.attached_to,     effect.robot.joint,
          effect.rule.allowed,           effect.rule.margin.value_or(-1)};
}

void from_json(const nlohmann::json& json, Effect& effect) {
  effect.kind = static_cast<Effect::Kind>(json.at(0).get<int>());
  json.at(1).get_to(effect.name);
  json.at(2).get_to(effect.object.place);
  json.at(3).get_to(effect.object.geometry);
  json.at(4).get_to(effect.object.attached_to);
  json.at(5).get_to(effect.robot.joint);
  json.at(6).get_to(effect.rule.allowed);
  const auto margin = json.at(7).get<std::int64_t>();
  if (margin >= 0) effect.rule.margin = margin;
}

}  // namespace cwm::fault
