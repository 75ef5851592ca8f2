// A robot as the subject of a query; declared in queries.h.
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "collision/geometry/validation.h"
#include "collision/query/attached_objects.h"
#include "collision/query/restrict_body.h"
#include "collision/world/apply_fault.h"
#include "collision/xml/xml_element.h"
#include "server/core/error.h"
#include "server/core/load_robot.h"
#include "server/wire/objects.h"
#include "server/wire/poses.h"
#include "server/wire/queries.h"
#include "server/wire/robot_settings.h"
#include "server/wire/robots.h"

namespace cwm::server {
namespace {

using collision::JointGroup;
using collision::Quoted;
using collision::RobotModel;

constexpr std::size_t kMaxNamesInError = 20;

absl::StatusOr<collision::RobotScope> RobotScopeFromProto(v1::RobotScope scope,
                                                          const FieldPath& path) {
  switch (scope) {
    case v1::ROBOT_SCOPE_UNSPECIFIED:
    case v1::ROBOT_SCOPE_BOTH:
      return collision::RobotScope::kBoth;
    case v1::ROBOT_SCOPE_WORLD:
      return collision::RobotScope::kWorld;
    case v1::ROBOT_SCOPE_SELF:
      return collision::RobotScope::kSelf;
    default:
      return path.Error(
          absl::StrCat("is ", static_cast<int>(scope), ", must be a known RobotScope"));
  }
}

absl::Status NoSpheres(const collision::WorldRobot& robot, const char* why, const FieldPath& path) {
  return MakeError(absl::StatusCode::kFailedPrecondition,
                   absl::StrCat(path.str(), ": robot ", Quoted(robot.name), " ", why),
                   {.reason = "NO_SPHERES", .metadata = {{"robot", robot.name}}});
}

// Checks the number of parts and pairs that a row tests without an interruption. `parts`: of each
// link.
absl::Status CheckSize(const RobotModel& model, const std::vector<std::int64_t>& parts,
                       collision::RobotScope scope, const FieldPath& path) {
  const std::int64_t count = std::accumulate(parts.begin(), parts.end(), std::int64_t{0});
  if (count > kMaxRobotParts) {
    return path.Field("robot_geometry")
        .Error(absl::StrCat("has ", count, " parts, must have at most ", kMaxRobotParts));
  }
  if (scope == collision::RobotScope::kWorld) return absl::OkStatus();
  std::int64_t pairs = 0;
  for (const auto& [first, second] : model.self_pairs) {
    pairs += parts[static_cast<std::size_t>(first)] * parts[static_cast<std::size_t>(second)];
  }
  if (pairs <= kMaxSelfPairs) return absl::OkStatus();
  return path.Field("scope").Error(absl::StrCat(
      "asks about ", pairs, " pairs of the robot's own parts, must be ROBOT_SCOPE_WORLD above ",
      kMaxSelfPairs));
}

// Sets the paddings of the request.
absl::Status SetPaddings(const google::protobuf::RepeatedPtrField<v1::LinkPadding>& paddings,
                         collision::QueryBody& body, const FieldPath& path) {
  const auto values = LinkPaddingsFromProto(paddings, path);
  if (!values.ok()) return values.status();
  for (std::size_t i = 0; i < values->size(); ++i) {
    const std::string& link = (*values)[i].link;
    if (link == collision::kOtherLinks || body.robot->FindLink(link)) continue;
    const FieldPath item = path.Item("link_padding", static_cast<int>(i));
    return item.Field("link").Error(
        absl::StrCat("is ", Quoted(link), ", must be a link of robot ", Quoted(body.robot->name)));
  }
  collision::SetPaddings(*values, body);
  return absl::OkStatus();
}

// Adds the pairs that rules of the world check, and checks their number.
absl::StatusOr<collision::QueryBody> WithChecked(collision::QueryBody bare,
                                                 const QuerySource& source,
                                                 collision::RobotScope scope,
                                                 const FieldPath& path) {
  const std::size_t before = bare.self_pairs.size();
  collision::QueryBody body =
      collision::WithCheckedPairs(std::move(bare), source.snapshot.pair_rules(), scope);
  const auto pairs = static_cast<std::int64_t>(body.self_pairs.size());
  if (body.self_pairs.size() == before || pairs <= kMaxSelfPairs) return body;
  return path.Field("scope").Error(
      absl::StrCat("asks about ", pairs,
                   " pairs of the robot's own parts with those that rules check, must be "
                   "ROBOT_SCOPE_WORLD above ",
                   kMaxSelfPairs));
}

// Adds the attached objects to the robot's body and checks the sizes again.
absl::StatusOr<collision::QueryBody> WithAttached(collision::QueryBody bare,
                                                  const QuerySource& source,
                                                  const collision::WorldRobot& robot,
                                                  collision::RobotScope scope,
                                                  const FieldPath& path) {
  const std::size_t attached = collision::CountAttachedParts(source.snapshot, robot, source.ignore);
  const auto parts = static_cast<std::int64_t>(bare.geometry->parts.size() + attached);
  if (attached > 0 && parts > kMaxRobotParts) {  // before their pairs, which are many more
    return path.Field("robot").Error(absl::StrCat("has ", parts,
                                                  " parts with what is attached to it, must have "
                                                  "at most ",
                                                  kMaxRobotParts));
  }
  collision::QueryBody body =
      collision::WithAttachedObjects(std::move(bare), source.snapshot, robot, scope, source.ignore);
  const auto pairs = static_cast<std::int64_t>(body.self_pairs.size());
  if (attached == 0 || pairs <= kMaxSelfPairs) return body;
  return path.Field("scope").Error(
      absl::StrCat("asks about ", pairs,
                   " pairs of the robot's own parts and of what is attached to it, must be "
                   "ROBOT_SCOPE_WORLD above ",
                   kMaxSelfPairs));
}

absl::Status CheckSphereCount(const collision::WorldRobot& robot,
                              const std::vector<int>& link_of_part, collision::RobotScope scope,
                              const FieldPath& path) {
  std::vector<std::int64_t> parts(robot.model().links.size(), 0);
  for (const int link : link_of_part) ++parts[static_cast<std::size_t>(link)];
  return CheckSize(robot.model(), parts, scope, path);
}

absl::StatusOr<collision::QueryBody> BodyOf(const collision::WorldRobot& robot,
                                            const v1::RobotSubject& subject,
                                            const FieldPath& path) {
  const auto scope = RobotScopeFromProto(subject.scope(), path.Field("scope"));
  if (!scope.ok()) return scope.status();
  const FieldPath geometry = path.Field("robot_geometry");
  std::vector<std::int64_t> parts;
  switch (subject.robot_geometry()) {
    case v1::ROBOT_GEOMETRY_UNSPECIFIED:
    case v1::ROBOT_GEOMETRY_EXACT: {
      for (const collision::ModelLink& link : robot.model().links) {
        parts.push_back(static_cast<std::int64_t>(link.collisions.size()));
      }
      auto status = CheckSize(robot.model(), parts, *scope, path);
      if (!status.ok()) return status;
      return BodyFromRobot(*robot.robot, *scope);
    }
    case v1::ROBOT_GEOMETRY_SPHERES_AS_GIVEN: {
      if (!robot.robot->spheres_as_given) {
        return NoSpheres(robot,
                         "was loaded without a sphere model, must be EXACT or SPHERES_CONTAINING: "
                         "load it with spheres",
                         geometry);
      }
      const collision::PreparedSpheres& spheres = *robot.robot->prepared_spheres_as_given;
      auto status = CheckSphereCount(robot, spheres.link_of_part, *scope, path);
      if (!status.ok()) return status;
      return BodyFromSpheres(*robot.robot, spheres, *scope);
    }
    case v1::ROBOT_GEOMETRY_SPHERES_CONTAINING: {
      if (!robot.robot->prepared_bounds) {
        return NoSpheres(robot, "has a link that no spheres contain, must be EXACT", geometry);
      }
      const collision::PreparedBounds& bounds = *robot.robot->prepared_bounds;
      auto status = CheckSphereCount(robot, bounds.link_of_part, *scope, path);
      if (!status.ok()) return status;
      return BodyFromBounds(*robot.robot, bounds, *scope);
    }
    default:
      return geometry.Error(absl::StrCat("is ", static_cast<int>(subject.robot_geometry()),
                                         ", must be a known RobotGeometry"));
  }
}

std::string RowField(std::size_t row) { return absl::StrCat("data row ", row); }

absl::StatusOr<const JointGroup*> GroupOf(const collision::WorldRobot& robot,
                                          const std::string& name, const FieldPath& path) {
  const RobotModel& model = robot.model();
  if (name.empty()) return &model.all;
  if (const JointGroup* group = model.FindGroup(name)) return group;
  std::vector<std::string> names;
  for (const JointGroup& group : model.groups) {
    names.push_back(names.size() < kMaxNamesInError ? Quoted(group.name) : "...");
    if (names.size() > kMaxNamesInError) break;
  }
  return path.Error(absl::StrCat("is ", Quoted(name), ", must be ",
                                 names.empty()
                                     ? std::string("empty: no SRDF with groups was loaded for ")
                                     : absl::StrCat("empty, for all variables, or one of ",
                                                    absl::StrJoin(names, ", "), " of "),
                                 Quoted(robot.name)));
}

// A value that was clamped to a limit and then rounded to single precision may lie beyond the
// limit; it is set to the limit.
double Unrounded(float value, const collision::Variable& variable) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  if (value > variable.upper && std::nextafter(value, -kInfinity) < variable.upper) {
    return variable.upper;
  }
  if (value < variable.lower && std::nextafter(value, kInfinity) > variable.lower) {
    return variable.lower;
  }
  return value;
}
double Unrounded(double value, const collision::Variable&) { return value; }

template <class Number>
absl::Status ReadValues(const RobotModel& model, const JointGroup& group, const std::string& data,
                        std::vector<double>& values, const FieldPath& path) {
  const std::size_t width = group.variables.size();
  for (std::size_t i = 0, k = 0; i < values.size(); ++i, k = k + 1 < width ? k + 1 : 0) {
    Number value;
    std::memcpy(&value, data.data() + i * sizeof(value), sizeof(value));
    const auto& variable = model.variables[static_cast<std::size_t>(group.variables[k])];
    values[i] = Unrounded(value, variable);
    if (std::abs(values[i]) <= kMaxCoordinate_m) continue;  // false for NaN
    return path.Field(RowField(i / width))
        .Error(absl::StrCat(variable.name, " is ", values[i], ", must be finite and at most ",
                            kMaxCoordinate_m, " in magnitude"));
  }
  return absl::OkStatus();
}

// Checks the quaternions of floating joints. A group has all variables of a joint, in sequence, or
// none.
absl::Status CheckQuaternions(const RobotModel& model, const JointGroup& group,
                              std::span<const double> values, const FieldPath& path) {
  constexpr int kQuaternionAt = 3;  // index within a floating joint's variables
  const std::size_t width = group.variables.size();
  for (std::size_t k = 0; k < width; ++k) {
    const auto& variable = model.variables[static_cast<std::size_t>(group.variables[k])];
    const auto& link = model.links[static_cast<std::size_t>(variable.link)];
    const bool is_first = variable.component == kQuaternionAt;
    if (link.kind != collision::JointKind::kFloating || !is_first) continue;
    for (std::size_t i = k; i < values.size(); i += width) {
      const double length = Eigen::Map<const Eigen::Vector4d>(&values[i]).norm();
      if (std::abs(length - 1) <= kQuaternionTolerance) continue;
      return path.Field(RowField(i / width))
          .Error(absl::StrCat("the quaternion of ", link.joint, " has length ", length,
                              ", must be 1 within 1e-3"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckWidth(const v1::JointRows& rows, const RobotRows& states, const FieldPath& path) {
  const std::vector<int>& variables = states.group->variables;
  if (rows.width() == 0 || static_cast<std::size_t>(rows.width()) == variables.size()) {
    return absl::OkStatus();
  }
  const std::string names = absl::StrJoin(variables, " ", [&](std::string* out, int variable) {
    absl::StrAppend(out, states.robot->model().variables[static_cast<std::size_t>(variable)].name);
  });
  return path.Field("width").Error(absl::StrCat("is ", rows.width(), ", must be ", variables.size(),
                                                ", one for each variable of the group: ", names));
}

absl::StatusOr<std::vector<double>> RowsFromProto(const v1::JointRows& rows,
                                                  const RobotRows& states, std::int64_t max_rows,
                                                  const FieldPath& path) {
  const JointGroup& group = *states.group;
  if (auto status = CheckWidth(rows, states, path); !status.ok()) return status;
  if (rows.data().empty()) {
    std::vector<double> row;
    for (const int variable : group.variables) {
      row.push_back(states.base[static_cast<std::size_t>(variable)]);
    }
    return row;
  }
  if (group.variables.empty()) {
    return path.Field("data").Error(absl::StrCat(
        "has ", rows.data().size(), " bytes, must be empty: the group has no variables"));
  }
  const auto count =
      CountRows({rows.scalar(), rows.data(), group.variables.size()}, max_rows, path);
  if (!count.ok()) return count.status();
  std::vector<double> values(*count * group.variables.size());
  const RobotModel& model = states.robot->model();
  const absl::Status status = rows.scalar() == v1::SCALAR_F32
                                  ? ReadValues<float>(model, group, rows.data(), values, path)
                                  : ReadValues<double>(model, group, rows.data(), values, path);
  if (!status.ok()) return status;
  if (auto turned = CheckQuaternions(model, group, values, path); !turned.ok()) return turned;
  return values;
}

absl::StatusOr<std::vector<double>> BaseFromProto(const v1::RobotJointState& joints,
                                                  const collision::WorldRobot& robot,
                                                  const FieldPath& path) {
  const auto values = JointValuesFromProto(joints, path);
  if (!values.ok()) return values.status();
  auto state = collision::StateWith(robot.model(), robot.state, *values);
  if (state.ok()) return state;
  const auto rule = collision::FieldRuleOf(state.status());
  return rule ? path.Field(rule->field).Error(rule->rule) : state.status();
}

// Refuses states in which a link's pose is out of range or not finite, since no answer would be
// meaningful.
absl::Status CheckRange(const RobotRows& states, const FieldPath& path, WorkBudget* budget) {
  const collision::JointRows rows = JointRowsOf(states);
  if (!rows.range().MayHaveFaults()) return absl::OkStatus();
  const std::size_t steps_of_row = 2 * states.robot->model().links.size();
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (MustEnd(budget, steps_of_row)) return budget->status();
    if (auto fault = rows.RangeFault(row))
      return path.Field(RowField(row)).Error(*std::move(fault));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ReadJointRows(const v1::JointRows& rows, std::int64_t max_rows, const FieldPath& path,
                           WorkBudget* budget, RobotRows& states) {
  auto read = RowsFromProto(rows, states, max_rows, path);
  if (!read.ok()) return read.status();
  states.rows = *std::move(read);
  return CheckRange(states, path, budget);
}

absl::StatusOr<StateQuery> RobotQueryFromProto(const v1::RobotSubject& subject,
                                               const QuerySource& source, const FieldPath& path) {
  if (auto status = CheckName(subject.robot(), path.Field("robot")); !status.ok()) return status;
  RobotRows states;
  states.robot = source.snapshot.FindRobot(subject.robot());
  if (states.robot == nullptr) return UnknownRobot(subject.robot());
  auto bare = BodyOf(*states.robot, subject, path);
  if (!bare.ok()) return bare.status();
  const auto scope = RobotScopeFromProto(subject.scope(), path.Field("scope"));
  if (!scope.ok()) return scope.status();
  bare->self = states.robot->name;  // pair rules refer to this name
  auto status = SetPaddings(subject.link_padding(), *bare, path);
  if (!status.ok()) return status;
  auto checked = WithChecked(*std::move(bare), source, *scope, path);
  if (!checked.ok()) return checked.status();
  auto body = WithAttached(*std::move(checked), source, *states.robot, *scope, path);
  if (!body.ok()) return body.status();
  const auto group = GroupOf(*states.robot, subject.group(), path.Field("group"));
  if (!group.ok()) return group.status();
  states.group = *group;
  states.X_WB = states.robot->X_WB;
  if (subject.has_x_world_base()) {
    const auto X_WB = PoseFromProto(subject.x_world_base(), path.Field("x_world_base"));
    if (!X_WB.ok()) return X_WB.status();
    states.X_WB = *X_WB;
  }
  auto base = BaseFromProto(subject.base_state(), *states.robot, path.Field("base_state"));
  if (!base.ok()) return base.status();
  states.base = *std::move(base);
  status = ReadJointRows(subject.rows(), source.limits.max_batch_rows, path.Field("rows"),
                         source.budget, states);
  if (!status.ok()) return status;
  return StateQuery{collision::RestrictBody(*std::move(body), source.only), std::move(states)};
}

collision::JointRows JointRowsOf(const RobotRows& states) {
  return {states.robot->model(),
          *states.group,
          {.X_WB = states.X_WB, .base = states.base, .rows = states.rows}};
}

std::unique_ptr<const collision::BodyRows> RowsOf(const StateQuery& query) {
  if (const auto* states = std::get_if<RobotRows>(&query.states)) {
    return std::make_unique<collision::JointRows>(JointRowsOf(*states));
  }
  return std::make_unique<collision::PoseRows>(std::get<std::vector<Pose>>(query.states));
}

std::unique_ptr<const collision::Waypoints> WaypointsOf(const StateQuery& query) {
  if (const auto* states = std::get_if<RobotRows>(&query.states)) {
    return std::make_unique<collision::JointWaypoints>(states->robot->model(), query.body,
                                                       JointRowsOf(*states));
  }
  return std::make_unique<collision::PoseWaypoints>(query.body,
                                                    std::get<std::vector<Pose>>(query.states));
}

BodyNames BodyNamesOf(const StateQuery& query) {
  BodyNames names;
  const auto* states = std::get_if<RobotRows>(&query.states);
  if (states == nullptr) return names;
  for (const collision::Variable& variable : states->robot->model().variables) {
    names.variables.push_back(variable.name);
  }
  for (const int variable : states->group->variables) {
    names.row_variables.push_back(names.variables[static_cast<std::size_t>(variable)]);
  }
  for (const int frame : query.body.frame_of_part) {
    const collision::AttachedObject* attached = query.body.AttachedIn(frame);
    const int link = attached != nullptr ? attached->link : frame;
    names.links.push_back(states->robot->model().links[static_cast<std::size_t>(link)].name);
    if (query.body.attached.empty()) continue;
    names.objects.push_back(attached != nullptr ? attached->object->name : "");
  }
  return names;
}

}  // namespace cwm::server
