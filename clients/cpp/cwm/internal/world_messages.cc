#include "cwm/internal/world_messages.h"

#include <cmath>
#include <cstdint>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "cwm/internal/session.h"

namespace cwm::CWM_API::internal {
namespace {

// chosen: a year and a day, the longest that the server takes.
constexpr double kMaxSeconds = 366.0 * 86'400;

Part PartFrom(const v1::ShapePart& message) {
  Part part{.shape = ShapeFrom(message), .X_OS = FromMessage(message.x_object_shape())};
  if (message.role() == v1::PART_ROLE_COMPLETED) part.role = PartRole::kCompleted;
  part.coefficients.assign(message.coefficients().begin(), message.coefficients().end());
  if (message.has_fit()) {
    const v1::FitQuality& fit = message.fit();
    part.fit =
        FitQuality{.rms_m = fit.rms_m(),
                   .max_residual_m = fit.max_residual_m(),
                   .inlier_count = fit.inlier_count(),
                   .inlier_ratio = fit.inlier_ratio(),
                   .observed_fraction = fit.observed_fraction(),
                   .parameter_sigma = {fit.parameter_sigma().begin(), fit.parameter_sigma().end()}};
  }
  if (message.has_vessel()) part.vessel = FromMessage(message.vessel());
  if (message.has_hidden()) part.hidden = FromMessage(message.hidden());
  return part;
}

NamedThing ThingFrom(const v1::NamedThing& message) { return {message.name(), message.link()}; }

void SetExpected(const std::optional<std::int64_t>& revision, v1::Change& message) {
  if (revision) message.set_expected_object_revision(*revision);
}

// Sets the change, whose parts errors name after `name`.
class ChangeWriter {
 public:
  ChangeWriter(const std::string& name, v1::Change& message, std::vector<MeshBlob>& meshes)
      : name_(name), message_(message), meshes_(meshes) {}

  void operator()(const Put& put) {
    v1::Object& object = *message_.mutable_put()->mutable_object();
    object.set_name(put.name);
    object.set_kind(static_cast<v1::ObjectKind>(put.kind));
    *object.mutable_x_world_object() = ToMessage(put.X_WO, Field("X_WO"));
    object.set_margin_m(put.margin_m);
    object.set_supported_by(put.supported_by);
    for (std::size_t i = 0; i < put.body.parts().size(); ++i) {
      const Placed& part = put.body.parts()[i];
      v1::ShapePart& shape = *object.add_shapes();
      *shape.mutable_x_object_shape() =
          ToMessage(part.X_BS, Field(absl::StrCat("body.parts[", i, "].X_BS")));
      SetShape(part.shape, shape, meshes_);
    }
    SetExpected(put.expected_revision, message_);
  }
  void operator()(const Move& move) {
    message_.mutable_move()->set_name(move.name);
    *message_.mutable_move()->mutable_x_world_object() = ToMessage(move.X_WO, Field("X_WO"));
    SetExpected(move.expected_revision, message_);
  }
  void operator()(const Remove& remove) {
    message_.mutable_remove()->set_name(remove.name);
    SetExpected(remove.expected_revision, message_);
  }
  void operator()(const Attach& attach) {
    v1::AttachObject& message = *message_.mutable_attach();
    message.set_name(attach.name);
    message.set_robot(attach.robot);
    message.set_link(attach.link);
    if (attach.X_LO) *message.mutable_x_link_object() = ToMessage(*attach.X_LO, Field("X_LO"));
    message.mutable_touch_links()->Assign(attach.touch_links.begin(), attach.touch_links.end());
    SetExpected(attach.expected_revision, message_);
  }
  void operator()(const Detach& detach) {
    message_.mutable_detach()->set_name(detach.name);
    SetExpected(detach.expected_revision, message_);
  }
  void operator()(const Allow& allow) {
    v1::AllowCollision& message = *message_.mutable_allow();
    *message.mutable_pair() = ToMessage(allow.a, allow.b);
    message.set_withdraw(allow.withdraw);
    message.set_check(allow.check);
    if (allow.expires_after_s) {
      *message.mutable_expires_after() =
          DurationFrom(*allow.expires_after_s, Field("expires_after_s"));
    }
  }
  void operator()(const Margin& margin) {
    *message_.mutable_margin()->mutable_pair() = ToMessage(margin.a, margin.b);
    if (margin.margin_m) message_.mutable_margin()->set_margin_m(*margin.margin_m);
  }
  void operator()(const SetState& state) {
    v1::SetRobotState& message = *message_.mutable_robot_state();
    message.set_name(state.robot);
    *message.mutable_joints() = ToMessage(state.joints);
    if (state.X_WB) *message.mutable_x_world_base() = ToMessage(*state.X_WB, Field("X_WB"));
    SetExpected(state.expected_revision, message_);
  }

 private:
  std::string Field(const std::string& member) const { return absl::StrCat(name_, ".", member); }

  const std::string& name_;
  v1::Change& message_;
  std::vector<MeshBlob>& meshes_;
};

}  // namespace

Time FromMessage(const google::protobuf::Timestamp& stamp) {
  return Time(std::chrono::duration_cast<Time::duration>(std::chrono::seconds(stamp.seconds()) +
                                                         std::chrono::nanoseconds(stamp.nanos())));
}

google::protobuf::Timestamp ToMessage(Time stamp) {
  using std::chrono::nanoseconds;
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t ns = std::chrono::duration_cast<nanoseconds>(stamp.time_since_epoch()).count();
  std::int64_t seconds = ns / kSecond;
  if (ns < seconds * kSecond) --seconds;  // nanos are not negative
  google::protobuf::Timestamp message;
  message.set_seconds(seconds);
  message.set_nanos(static_cast<std::int32_t>(ns - seconds * kSecond));
  return message;
}

google::protobuf::Duration DurationFrom(double seconds, const std::string& name) {
  if (!(seconds >= 0 && seconds <= kMaxSeconds)) {
    ThrowBadArgument(name, absl::StrCat("is ", seconds, ", must be 0 to ", kMaxSeconds, " s"));
  }
  google::protobuf::Duration duration;
  const auto nanoseconds = static_cast<std::int64_t>(std::llround(1e9 * seconds));
  duration.set_seconds(nanoseconds / 1'000'000'000);
  duration.set_nanos(static_cast<std::int32_t>(nanoseconds % 1'000'000'000));
  return duration;
}

void SetSensor(const std::variant<SensorModel, SensorNoise>& sensor, v1::SensorModel& message) {
  if (const auto* model = std::get_if<SensorModel>(&sensor)) {
    message.set_kind(static_cast<v1::SensorModel::Kind>(*model));
    return;
  }
  const auto& noise = std::get<SensorNoise>(sensor);
  message.set_kind(noise.b_per_m == 0 ? v1::SensorModel::KIND_CONSTANT
                                      : v1::SensorModel::KIND_QUADRATIC);
  message.set_sigma_m(noise.a_m);
  message.set_quadratic_per_m(noise.b_per_m);
}

Object FromMessage(const v1::Object& message) {
  Object object{.name = message.name(), .uid = message.uid()};
  object.kind = static_cast<ObjectKind>(message.kind());
  object.owner = static_cast<Owner>(message.owner());
  object.state = static_cast<ObjectState>(message.state());
  object.X_WO = FromMessage(message.x_world_object());
  for (const v1::ShapePart& part : message.shapes()) object.parts.push_back(PartFrom(part));
  for (const v1::SurfacePart& surface : message.surfaces()) {
    object.surfaces.push_back({.hash = surface.hash(),
                               .vertex_count = surface.vertex_count(),
                               .triangle_count = surface.triangle_count(),
                               .watertight = surface.watertight(),
                               .point_count = surface.point_count()});
  }
  for (const v1::Handle& handle : message.handles()) {
    object.handles.push_back({.shape_index = handle.shape_index(),
                              .point_count = handle.point_count(),
                              .axis_O = FromMessage(handle.axis()),
                              .bounds = FromMessage(handle.bounds()),
                              .hash = handle.hash()});
  }
  object.supported_by = message.supported_by();
  if (message.has_bounds()) object.bounds = FromMessage(message.bounds());
  object.point_count = message.point_count();
  object.create_revision = message.create_revision();
  object.geometry_revision = message.geometry_revision();
  object.pose_revision = message.pose_revision();
  if (message.has_last_observed()) object.last_observed = FromMessage(message.last_observed());
  object.margin_m = message.margin_m();
  if (message.has_attachment()) {
    const v1::Attachment& attachment = message.attachment();
    object.attachment = Attachment{
        .robot = attachment.robot(),
        .link = attachment.link(),
        .X_LO = FromMessage(attachment.x_link_object()),
        .touch_links = {attachment.touch_links().begin(), attachment.touch_links().end()}};
  }
  if (message.has_reachable()) object.reachable = message.reachable();
  object.motion = static_cast<Motion>(message.motion());
  object.visibility = static_cast<Visibility>(message.visibility());
  if (message.has_identity_certain()) object.identity_certain = message.identity_certain();
  object.carried_by = message.carried_by();
  return object;
}

Robot FromMessage(const v1::Robot& message) {
  Robot robot{.name = message.name(), .uid = message.uid()};
  for (const v1::RobotLink& link : message.links()) {
    robot.links.push_back(
        {.name = link.name(),
         .parent = link.parent(),
         .joint = link.joint(),
         .joint_kind = static_cast<JointKind>(link.joint_kind()),
         .follows = link.follows(),
         .collision_count = link.collision_count(),
         .triangle_count = link.triangle_count(),
         .sphere_count = link.sphere_count(),
         .unchecked_links = {link.unchecked_links().begin(), link.unchecked_links().end()},
         .padding_m = link.padding_m(),
         .scale = link.scale()});
  }
  for (const v1::RobotVariable& variable : message.variables()) {
    Variable& added = robot.variables.emplace_back();
    added.name = variable.name();
    added.joint = variable.joint();
    added.joint_kind = static_cast<JointKind>(variable.joint_kind());
    if (variable.has_lower()) added.lower = variable.lower();
    if (variable.has_upper()) added.upper = variable.upper();
  }
  for (const v1::RobotGroup& group : message.groups()) {
    Group& added = robot.groups.emplace_back();
    added.name = group.name();
    added.joints.assign(group.joints().begin(), group.joints().end());
    for (const v1::NamedState& state : group.states()) {
      std::map<std::string, double>& values = added.states[state.name()];
      for (const v1::VariableValue& value : state.values()) {
        values[value.variable()] = value.value();
      }
    }
  }
  for (const v1::RobotTool& tool : message.tools()) {
    robot.tools.push_back({.name = tool.name(),
                           .link = tool.link(),
                           .X_LT = FromMessage(tool.x_link_tool()),
                           .group = tool.group()});
  }
  robot.self_pair_count = message.self_pair_count();
  robot.X_WB = FromMessage(message.x_world_base());
  robot.state = Eigen::Map<const Eigen::VectorXd>(message.state().data(), message.state_size());
  robot.create_revision = message.create_revision();
  robot.state_revision = message.state_revision();
  return robot;
}

PairRule FromMessage(const v1::PairRule& message) {
  PairRule rule{.a = ThingFrom(message.pair().a()),
                .b = ThingFrom(message.pair().b()),
                .allowed = message.allowed(),
                .check = message.check()};
  if (message.has_expires()) rule.expires = FromMessage(message.expires());
  if (message.has_margin_m()) rule.margin_m = message.margin_m();
  return rule;
}

v1::NamedThing ToMessage(const NamedThing& thing) {
  v1::NamedThing message;
  message.set_name(thing.name);
  message.set_link(thing.link);
  return message;
}

v1::NamedPair ToMessage(const NamedThing& a, const NamedThing& b) {
  v1::NamedPair pair;
  *pair.mutable_a() = ToMessage(a);
  *pair.mutable_b() = ToMessage(b);
  return pair;
}

v1::RobotJointState ToMessage(const JointState& state) {
  v1::RobotJointState message;
  if (state.named) {
    message.set_group(state.named->group);
    message.set_named_state(state.named->state);
  }
  for (const auto& [variable, value] : state.values) {
    v1::VariableValue& added = *message.add_values();
    added.set_variable(variable);
    added.set_value(value);
  }
  return message;
}

v1::LinkPadding ToMessage(const LinkPadding& padding) {
  v1::LinkPadding message;
  message.set_link(padding.link);
  message.set_padding_m(padding.padding_m);
  return message;
}

v1::RobotTool ToMessage(const Tool& tool, const std::string& name) {
  v1::RobotTool message;
  message.set_name(tool.name);
  message.set_link(tool.link);
  *message.mutable_x_link_tool() = ToMessage(tool.X_LT, absl::StrCat(name, ".X_LT"));
  message.set_group(tool.group);
  return message;
}

v1::Change ToMessage(const Change& change, const std::string& name, std::vector<MeshBlob>& meshes) {
  v1::Change message;
  std::visit(ChangeWriter(name, message, meshes), change);
  return message;
}

}  // namespace cwm::CWM_API::internal
