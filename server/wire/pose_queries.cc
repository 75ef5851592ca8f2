// Poses of a tool, and poses of links; declared in queries.h and answers.h.
#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "collision/robot/kinematics.h"
#include "collision/xml/xml_element.h"
#include "server/wire/answers.h"
#include "server/wire/poses.h"
#include "server/wire/queries.h"
#include "server/wire/scalar_columns.h"

namespace cwm::server {
namespace {

using collision::Quoted;

constexpr int kMaxSolutions = 64;
// chosen: some 50 ms for one pose.
constexpr int kMaxSteps = 100'000;
constexpr double kDefaultTolerance = 1e-6;

absl::StatusOr<int> LinkOf(const collision::RobotModel& model, const std::string& name,
                           const FieldPath& path) {
  const std::optional<int> link = model.FindLink(name);
  if (link) return *link;
  return path.Error(
      absl::StrCat("is ", Quoted(name), ", must be a link of robot ", Quoted(model.name)));
}

absl::StatusOr<int> ToolLinkOf(const RobotRows& states, const std::string& name,
                               const FieldPath& path) {
  const collision::RobotModel& model = states.robot->model();
  if (!name.empty()) return LinkOf(model, name, path);
  if (states.group->tool_link) return *states.group->tool_link;
  const std::string who = states.group->name.empty()
                              ? "the whole robot"
                              : absl::StrCat("group ", Quoted(states.group->name));
  return path.Error(absl::StrCat("is empty, must name the link that carries the tool: ", who,
                                 " has no end effector in the SRDF and not just one end"));
}

// The tool that the request names, or the only one of the group; nullptr: the request has a link.
absl::StatusOr<const collision::RobotTool*> ToolOf(const v1::SolvePosesRequest& request,
                                                   const RobotRows& states, const FieldPath& path) {
  const collision::RobotModel& model = states.robot->model();
  if (!request.tool().empty()) {
    const char* const other = !request.tool_link().empty() ? "tool_link"
                              : request.has_x_link_tool()  ? "x_link_tool"
                                                           : nullptr;
    if (other != nullptr) {
      return path.Error(absl::StrCat("is ", Quoted(request.tool()), ", must be empty: ", other,
                                     " is given, too"));
    }
    const collision::RobotTool* const tool = model.FindTool(request.tool());
    if (tool != nullptr) return tool;
    const std::string names =
        absl::StrJoin(model.tools, ", ", [](std::string* out, const collision::RobotTool& each) {
          absl::StrAppend(out, Quoted(each.name));
        });
    return path.Error(
        absl::StrCat("is ", Quoted(request.tool()), ", must be ",
                     model.tools.empty() ? "empty: no tools were loaded with " : "one of ", names,
                     model.tools.empty() ? "" : " of ", Quoted(states.robot->name)));
  }
  const std::string& group = states.group->name;
  if (!request.tool_link().empty() || group.empty()) return nullptr;
  const auto is_default = [&](const collision::RobotTool& tool) { return tool.group == group; };
  const auto found = std::ranges::find_if(model.tools, is_default);
  if (std::ranges::count_if(model.tools, is_default) != 1) return nullptr;
  return &*found;
}

absl::StatusOr<double> ToleranceOf(double tolerance, const FieldPath& path) {
  if (tolerance == 0) return kDefaultTolerance;
  if (tolerance > 0 && std::isfinite(tolerance)) return tolerance;
  return path.Error(absl::StrCat("is ", tolerance, ", must be positive, or 0 for 1e-6"));
}

absl::Status CheckRange(int value, int most, const FieldPath& path) {
  if (value >= 0 && value <= most) return absl::OkStatus();
  return path.Error(absl::StrCat("is ", value, ", must be 0 to ", most));
}

absl::Status CheckSeeds(const PoseQuery& query, const FieldPath& path) {
  const auto& states = std::get<RobotRows>(query.query.states);
  const std::size_t seeds = states.rows.size() / states.group->variables.size();
  if (seeds == 1 || seeds == query.X_WT.size()) return absl::OkStatus();
  return path.Error(absl::StrCat("has ", seeds, " rows, must have 1, or one for each of the ",
                                 query.X_WT.size(), " poses"));
}

// Reads how to search.
absl::Status ReadSearch(const v1::SolvePosesRequest& request, collision::PoseBatch& batch) {
  const FieldPath root;
  const auto position =
      ToleranceOf(request.position_tolerance_m(), root.Field("position_tolerance_m"));
  if (!position.ok()) return position.status();
  const auto rotation =
      ToleranceOf(request.rotation_tolerance_rad(), root.Field("rotation_tolerance_rad"));
  if (!rotation.ok()) return rotation.status();
  absl::Status status =
      CheckRange(request.max_solutions(), kMaxSolutions, root.Field("max_solutions"));
  if (status.ok()) status = CheckRange(request.max_steps(), kMaxSteps, root.Field("max_steps"));
  if (!status.ok()) return status;
  batch.position_tolerance_m = *position;
  batch.rotation_tolerance_rad = *rotation;
  batch.max_solutions = std::max(1, request.max_solutions());
  if (request.max_steps() > 0) batch.max_steps = request.max_steps();
  batch.same_branch = request.same_branch();
  batch.avoid_collision = request.avoid_collision();
  return absl::OkStatus();
}

std::vector<std::string> VariablesOf(const RobotRows& states) {
  std::vector<std::string> names;
  for (const int variable : states.group->variables) {
    names.push_back(states.robot->model().variables[static_cast<std::size_t>(variable)].name);
  }
  return names;
}

v1::PoseStatus StatusToProto(collision::PoseStatus status) {
  switch (status) {
    case collision::PoseStatus::kSolved:
      return v1::POSE_STATUS_SOLVED;
    case collision::PoseStatus::kUnreachable:
      return v1::POSE_STATUS_UNREACHABLE;
    case collision::PoseStatus::kOutOfLimits:
      return v1::POSE_STATUS_OUT_OF_LIMITS;
    case collision::PoseStatus::kInCollision:
      return v1::POSE_STATUS_IN_COLLISION;
    case collision::PoseStatus::kNotComputed:
      return v1::POSE_STATUS_NOT_COMPUTED;
  }
  return v1::POSE_STATUS_UNSPECIFIED;
}

void SetRows(const collision::PoseColumns& answers, const RobotRows& states,
             v1::SolvePosesResponse* response) {
  const std::size_t width = states.group->variables.size();
  for (std::size_t pose = 0; pose < answers.completed; ++pose) {
    v1::SolvedPoseRow* const row = response->add_rows();
    row->set_status(StatusToProto(answers.status[pose]));
    for (std::size_t k = answers.row_begin[pose]; k < answers.row_begin[pose + 1]; ++k) {
      v1::PoseSolution* const solution = row->add_solutions();
      const auto first = answers.rows.begin() + static_cast<std::ptrdiff_t>(k * width);
      solution->mutable_joints()->Assign(first, first + static_cast<std::ptrdiff_t>(width));
      solution->set_position_error_m(answers.position_error_m[k]);
      solution->set_rotation_error_rad(answers.rotation_error_rad[k]);
    }
  }
}

v1::Scalar ScalarOf(Precision precision) {
  return precision == Precision::kSingle ? v1::SCALAR_F32 : v1::SCALAR_F64;
}

void Append(const Pose& X, std::vector<double>& numbers) {
  const Vector3& p = X.translation();
  Quaternion q(X.linear());
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  numbers.insert(numbers.end(), {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()});
}

}  // namespace

absl::StatusOr<PoseQuery> PoseQueryFromProto(const v1::SolvePosesRequest& request,
                                             const QuerySource& source) {
  const FieldPath root;
  const FieldPath robot = root.Field("robot");
  auto states_query = RobotQueryFromProto(request.robot(), source, robot);
  if (!states_query.ok()) return states_query.status();
  PoseQuery query{.query = *std::move(states_query)};
  const auto& states = std::get<RobotRows>(query.query.states);
  const auto tool = ToolOf(request, states, root.Field("tool"));
  if (!tool.ok()) return tool.status();
  const FieldPath tool_link = root.Field(request.tool().empty() ? "tool_link" : "tool");
  const auto link = *tool != nullptr ? absl::StatusOr<int>((*tool)->link)
                                     : ToolLinkOf(states, request.tool_link(), tool_link);
  if (!link.ok()) return link.status();
  query.tool_link = states.robot->model().links[static_cast<std::size_t>(*link)].name;
  Pose X_LT = *tool != nullptr ? (*tool)->X_LT : Pose::Identity();
  if (request.has_x_link_tool()) {
    const auto given = PoseFromProto(request.x_link_tool(), root.Field("x_link_tool"));
    if (!given.ok()) return given.status();
    X_LT = *given;
  }
  auto chain = MakeIkChain(states.robot->model(), *states.group, states.base, *link, X_LT);
  if (!chain.ok()) {
    return tool_link.Error(
        absl::StrCat("is ", Quoted(query.tool_link), ": ", std::string(chain.status().message())));
  }
  query.chain = *std::move(chain);
  auto poses = PosesFromProto(request.x_world_tool(), source.limits.max_batch_rows,
                              root.Field("x_world_tool"));
  if (!poses.ok()) return poses.status();
  query.X_WT = *std::move(poses);
  const FieldPath rows = robot.Field("rows");
  if (auto status = CheckSeeds(query, rows); !status.ok()) return status;
  if (auto status = ReadSearch(request, query.batch); !status.ok()) return status;
  return query;
}

collision::PoseBatch BatchOf(const PoseQuery& query) {
  const auto& states = std::get<RobotRows>(query.query.states);
  collision::PoseBatch batch = query.batch;
  batch.X_WT = query.X_WT;
  batch.X_WB = states.X_WB;
  batch.seeds = states.rows;
  return batch;
}

void PoseAnswersToProto(const collision::PoseColumns& answers, const PoseQuery& query,
                        const AnswerContext& context, v1::SolvePosesResponse* response) {
  const auto& states = std::get<RobotRows>(query.query.states);
  response->set_world_uid(context.world_uid);
  response->set_revision(context.revision.value);
  response->set_completed_count(static_cast<std::int64_t>(answers.completed));
  response->set_tool_link(query.tool_link);
  for (std::string& name : VariablesOf(states)) response->add_variables(std::move(name));
  if (context.form == Form::kRows) return SetRows(answers, states, response);
  std::string* const status = response->mutable_status();
  for (const collision::PoseStatus each : answers.status) {
    status->push_back(static_cast<char>(StatusToProto(each)));
  }
  response->set_row_begin(NumberBytes(answers.row_begin));
  v1::JointRows* const rows = response->mutable_joints();
  rows->set_scalar(ScalarOf(context.precision));
  rows->set_width(static_cast<int>(states.group->variables.size()));
  rows->set_data(Scalars(answers.rows, context.precision));
  response->set_position_error_m(Scalars(answers.position_error_m, context.precision));
  response->set_rotation_error_rad(Scalars(answers.rotation_error_rad, context.precision));
}

absl::StatusOr<std::vector<int>> LinksFromProto(const v1::GetLinkPosesRequest& request,
                                                const StateQuery& query) {
  const collision::RobotModel& model = std::get<RobotRows>(query.states).robot->model();
  std::vector<int> links;
  const FieldPath root;
  for (int i = 0; i < request.links_size(); ++i) {
    const auto link = LinkOf(model, request.links(i), root.Item("links", i));
    if (!link.ok()) return link.status();
    links.push_back(*link);
  }
  if (!links.empty()) return links;
  links.resize(model.links.size());
  for (std::size_t k = 0; k < links.size(); ++k) {
    links[static_cast<std::size_t>(model.links[k].urdf_index)] = static_cast<int>(k);
  }
  return links;
}

void LinkPosesToProto(const StateQuery& query, std::span<const int> links,
                      const AnswerContext& context, WorkBudget* budget,
                      v1::GetLinkPosesResponse* response) {
  const auto& states = std::get<RobotRows>(query.states);
  const collision::RobotModel& model = states.robot->model();
  const collision::JointRows rows = JointRowsOf(states);
  std::vector<Pose> X_WL(model.links.size());
  std::vector<double> numbers;
  std::size_t row = 0;
  for (; row < rows.size() && !MustEnd(budget, 2 * X_WL.size()); ++row) {
    collision::LinkPoses(model, states.X_WB, rows.State(row), X_WL);
    for (const int link : links) Append(X_WL[static_cast<std::size_t>(link)], numbers);
  }
  response->set_world_uid(context.world_uid);
  response->set_revision(context.revision.value);
  response->set_completed_count(static_cast<std::int64_t>(row));
  for (const int link : links) {
    response->add_links(model.links[static_cast<std::size_t>(link)].name);
  }
  response->mutable_x_world_link()->set_scalar(ScalarOf(context.precision));
  response->mutable_x_world_link()->set_data(Scalars(numbers, context.precision));
}

}  // namespace cwm::server
