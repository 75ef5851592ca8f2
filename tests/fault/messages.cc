#include "tests/fault/messages.h"

#include <array>
#include <charconv>
#include <cmath>

#include "tests/fault/calls.h"

namespace cwm::fault {
namespace {

double Metres(std::int64_t steps) { return static_cast<double>(steps) / kStepsPerMetre; }

// Adds a mark to `text` for a number that is no whole step.
std::int64_t Steps(double metres, std::string& text) {
  const double steps = metres * kStepsPerMetre;
  if (steps != std::round(steps)) text += "!" + std::to_string(metres);
  return std::llround(steps);
}

Place PlaceOf(const v1::Pose& pose, std::string& text) {
  if (pose.qx() != 0 || pose.qy() != 0 || pose.qz() != 0 || pose.qw() != 1) text += "!rotated";
  return {Steps(pose.tx_m(), text), Steps(pose.ty_m(), text), Steps(pose.tz_m(), text)};
}

void SetPlace(const Place& place, v1::Pose* pose) {
  pose->set_tx_m(Metres(place[0]));
  pose->set_ty_m(Metres(place[1]));
  pose->set_tz_m(Metres(place[2]));
  pose->set_qw(1);
}

void SetShape(const std::string& geometry, v1::ShapePart* part) {
  if (geometry.starts_with("mesh:")) {
    part->mutable_mesh()->set_hash(geometry.substr(5));
    return;
  }
  std::array<std::int64_t, 3> size = {};
  const char* at = geometry.data() + std::string("box:").size();
  const char* const end = geometry.data() + geometry.size();
  for (std::int64_t& edge : size) {
    at = std::from_chars(at, end, edge).ptr;
    if (at != end) ++at;  // the colon
  }
  part->mutable_box()->set_size_x_m(Metres(size[0]));
  part->mutable_box()->set_size_y_m(Metres(size[1]));
  part->mutable_box()->set_size_z_m(Metres(size[2]));
}

std::string GeometryOf(const v1::Object& object) {
  std::string text;
  for (const v1::ShapePart& part : object.shapes()) {
    if (!text.empty()) text += "+";
    if (part.has_mesh()) {
      text += "mesh:" + part.mesh().hash();
    } else if (part.has_box()) {
      const std::array<double, 3> size = {part.box().size_x_m(), part.box().size_y_m(),
                                          part.box().size_z_m()};
      std::string marks;
      text += "box";
      for (const double edge : size) text += ":" + std::to_string(Steps(edge, marks));
      text += marks;
    } else {
      text += "!" + part.ShortDebugString();
    }
  }
  if (object.kind() != v1::OBJECT_KIND_USER) text += "!kind";
  if (object.owner() != v1::OWNER_USER) text += "!owner";
  return text;
}

void SetPair(const Change& change, v1::NamedPair* pair) {
  pair->mutable_a()->set_name(change.name);
  pair->mutable_b()->set_name(change.other);
}

Effect ObjectEffect(const v1::Object& object) {
  return {.kind = Effect::Kind::kObject, .name = object.name(), .object = ToObject(object)};
}

Effect RobotEffect(const v1::Robot& robot) {
  return {.kind = Effect::Kind::kRobot, .name = robot.name(), .robot = ToRobot(robot)};
}

Effect RuleEffect(const v1::PairRule& rule) {
  return {.kind = Effect::Kind::kRule, .name = KeyOf(rule), .rule = ToRule(rule)};
}

Effect ToEffect(const v1::ObjectEvent& event) {
  if (event.has_put()) return ObjectEffect(event.put());
  if (event.has_move()) {
    Effect effect{.kind = Effect::Kind::kMove, .name = event.move().name()};
    std::string marks;
    effect.object.place = PlaceOf(event.move().x_world_object(), marks);
    return effect;
  }
  return {.kind = Effect::Kind::kRemoveObject, .name = event.remove()};
}

Effect ToEffect(const v1::RobotEvent& event) {
  if (event.has_put()) return RobotEffect(event.put());
  if (event.has_state()) {
    Effect effect{.kind = Effect::Kind::kRobotState, .name = event.state().name()};
    std::string marks;
    if (event.state().state_size() > 0) effect.robot.joint = Steps(event.state().state(0), marks);
    return effect;
  }
  return {.kind = Effect::Kind::kRemoveRobot, .name = event.remove()};
}

}  // namespace

v1::Change ToMessage(const Change& change) {
  v1::Change message;
  switch (change.kind) {
    case Change::Kind::kPut: {
      v1::Object* const object = message.mutable_put()->mutable_object();
      object->set_name(change.name);
      SetPlace(change.place, object->mutable_x_world_object());
      SetShape(change.geometry, object->add_shapes());
      break;
    }
    case Change::Kind::kMove:
      message.mutable_move()->set_name(change.name);
      SetPlace(change.place, message.mutable_move()->mutable_x_world_object());
      break;
    case Change::Kind::kRemove:
      message.mutable_remove()->set_name(change.name);
      break;
    case Change::Kind::kRobotState: {
      message.mutable_robot_state()->set_name(change.name);
      v1::VariableValue* const value =
          message.mutable_robot_state()->mutable_joints()->add_values();
      value->set_variable("slide");
      value->set_value(Metres(change.value));
      break;
    }
    case Change::Kind::kAllow:
      SetPair(change, message.mutable_allow()->mutable_pair());
      message.mutable_allow()->set_withdraw(change.value == 0);
      break;
    case Change::Kind::kMargin:
      SetPair(change, message.mutable_margin()->mutable_pair());
      if (change.value >= 0) message.mutable_margin()->set_margin_m(Metres(change.value));
      break;
    case Change::Kind::kAttach:
      message.mutable_attach()->set_name(change.name);
      message.mutable_attach()->set_robot(change.other);
      message.mutable_attach()->set_link("plate");
      break;
    case Change::Kind::kDetach:
      message.mutable_detach()->set_name(change.name);
      break;
    case Change::Kind::kLoadRobot:
    case Change::Kind::kDeleteRobot:
      break;
  }
  return message;
}

ModelObject ToObject(const v1::Object& object) {
  ModelObject model{.geometry = GeometryOf(object), .attached_to = object.attached_to()};
  model.place = PlaceOf(object.x_world_object(), model.geometry);
  return model;
}

ModelRobot ToRobot(const v1::Robot& robot) {
  std::string marks;
  return {.joint = robot.state_size() == 1 ? Steps(robot.state(0), marks) : -1};
}

ModelRule ToRule(const v1::PairRule& rule) {
  ModelRule model{.allowed = rule.allowed()};
  std::string marks;
  if (rule.has_margin_m()) model.margin = Steps(rule.margin_m(), marks);
  return model;
}

std::string KeyOf(const v1::PairRule& rule) {
  return RuleKey(rule.pair().a().name(), rule.pair().b().name());
}

WatchMessage ToWatchMessage(const v1::WatchWorldResponse& response, std::int64_t time_ns) {
  WatchMessage message{.time_ns = time_ns, .revision = response.revision()};
  if (response.has_initial_state()) {
    message.kind = WatchMessage::Kind::kInitialState;
    message.more = !response.initial_state().initial_state_done();
    for (const auto& object : response.initial_state().objects()) {
      message.effects.push_back(ObjectEffect(object));
    }
    for (const auto& robot : response.initial_state().robots()) {
      message.effects.push_back(RobotEffect(robot));
    }
    for (const auto& rule : response.initial_state().pair_rules()) {
      message.effects.push_back(RuleEffect(rule));
    }
  } else if (response.has_events()) {
    message.kind = WatchMessage::Kind::kEvents;
    message.more = response.events().more();
    for (const auto& event : response.events().events()) message.effects.push_back(ToEffect(event));
    for (const auto& event : response.events().robot_events()) {
      message.effects.push_back(ToEffect(event));
    }
    for (const auto& rule : response.events().pair_rules()) {
      message.effects.push_back(RuleEffect(rule));
    }
  }
  return message;
}

}  // namespace cwm::fault
