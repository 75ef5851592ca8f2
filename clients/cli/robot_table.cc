#include "clients/cli/robot_table.h"

#include <algorithm>
#include <ostream>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/natural_order.h"
#include "clients/cli/quantity.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

constexpr int kDecimals = 3;  // milliradians and millimetres

// Empty for zero, so that a column without any count is omitted.
std::string Count(std::int64_t count) { return count == 0 ? "" : absl::StrCat(count); }

// E.g. "revolute".
std::string KindText(pb::JointKind kind) {
  constexpr std::size_t kPrefix = sizeof("JOINT_KIND_") - 1;
  const std::string name = pb::JointKind_Name(kind);
  return kind == pb::JOINT_KIND_UNSPECIFIED || name.size() < kPrefix
             ? ""
             : absl::AsciiStrToLower(name.substr(kPrefix));
}

TableRow RobotRow(const pb::Robot& robot) {
  std::int64_t bodies = 0, triangles = 0, spheres = 0;
  for (const pb::RobotLink& link : robot.links()) {
    bodies += link.collision_count() > 0 ? 1 : 0;
    triangles += link.triangle_count();
    spheres += link.sphere_count();
  }
  return {{robot.name(), absl::StrCat(robot.links_size()), absl::StrCat(bodies), Count(triangles),
           Count(spheres), absl::StrCat(robot.variables_size()), Count(robot.groups_size()),
           absl::StrCat(robot.self_pair_count()), FormatPose(robot.x_world_base())}};
}

void PrintLinks(const pb::Robot& robot, TableStyle style, std::ostream& out) {
  std::vector<TableRow> rows;
  for (const pb::RobotLink& link : robot.links()) {
    const std::string kind = link.follows().empty() ? KindText(link.joint_kind())
                                                    : absl::StrCat(KindText(link.joint_kind()),
                                                                   ", follows ", link.follows());
    rows.push_back({{link.name(), link.parent(), link.joint(), kind, Count(link.collision_count()),
                     Count(link.triangle_count()), Count(link.sphere_count()),
                     link.padding_m() > 0 ? FormatLength(link.padding_m()) : "",
                     link.scale() == 1 ? "" : FormatFixed(link.scale(), kDecimals)}});
  }
  PrintTable({{"LINK"},
              {"ON"},
              {"JOINT"},
              {"KIND"},
              {"SHAPES", Align::kRight},
              {"TRIANGLES", Align::kRight},
              {"SPHERES", Align::kRight},
              {"PADDING", Align::kRight},
              {"SCALE", Align::kRight}},
             rows, style, out);
}

void PrintTools(const pb::Robot& robot, TableStyle style, std::ostream& out) {
  std::vector<TableRow> rows;
  for (const pb::RobotTool& tool : robot.tools()) {
    rows.push_back({{tool.name(), tool.link(), FormatPose(tool.x_link_tool()), tool.group()}});
  }
  PrintTable({{"TOOL"}, {"ON"}, {"IN ITS FRAME"}, {"GROUP"}}, rows, style, out);
}

void PrintVariables(const pb::Robot& robot, TableStyle style, std::ostream& out) {
  std::vector<TableRow> rows;
  const int count = std::min(robot.variables_size(), robot.state_size());
  for (int i = 0; i < count; ++i) {
    const pb::RobotVariable& variable = robot.variables(i);
    rows.push_back({{variable.name(), KindText(variable.joint_kind()),
                     variable.has_lower() ? FormatFixed(variable.lower(), kDecimals) : "",
                     FormatFixed(robot.state(i), kDecimals),
                     variable.has_upper() ? FormatFixed(variable.upper(), kDecimals) : ""}});
  }
  PrintTable({{"VARIABLE rad, m"},
              {"KIND"},
              {"LOWER", Align::kRight},
              {"VALUE", Align::kRight},
              {"UPPER", Align::kRight}},
             rows, style, out);
}

void PrintGroups(const pb::Robot& robot, TableStyle style, std::ostream& out) {
  std::vector<TableRow> rows;
  for (const pb::RobotGroup& group : robot.groups()) {
    const std::string states =
        absl::StrJoin(group.states(), ", ", [](std::string* text, const pb::NamedState& state) {
          absl::StrAppend(text, state.name());
        });
    rows.push_back({{group.name(), absl::StrCat(group.joints_size()), states},
                    absl::StrJoin(group.joints(), " ")});
  }
  PrintTable({{"GROUP"}, {"JOINTS", Align::kRight}, {"STATES"}}, rows, style, out);
}

}  // namespace

void PrintRobots(const google::protobuf::RepeatedPtrField<pb::Robot>& robots, TableStyle style,
                 std::ostream& out) {
  std::vector<TableRow> rows;
  for (const pb::Robot& robot : robots) rows.push_back(RobotRow(robot));
  std::stable_sort(rows.begin(), rows.end(), [](const TableRow& a, const TableRow& b) {
    return NaturalLess(a.cells[0], b.cells[0]);
  });
  PrintTable({{"ROBOT"},
              {"LINKS", Align::kRight},
              {"WITH SHAPES", Align::kRight},
              {"TRIANGLES", Align::kRight},
              {"SPHERES", Align::kRight},
              {"VARIABLES", Align::kRight},
              {"GROUPS", Align::kRight},
              {"SELF PAIRS", Align::kRight},
              {"BASE"}},
             rows, style, out);
}

void PrintRobotDetails(const pb::Robot& robot, TableStyle style, std::ostream& out) {
  google::protobuf::RepeatedPtrField<pb::Robot> one;
  *one.Add() = robot;
  PrintRobots(one, style, out);
  out << "\n";
  PrintLinks(robot, style, out);
  if (!robot.variables().empty()) {
    out << "\n";
    PrintVariables(robot, style, out);
  }
  if (!robot.groups().empty()) {
    out << "\n";
    PrintGroups(robot, style, out);
  }
  if (robot.tools().empty()) return;
  out << "\n";
  PrintTools(robot, style, out);
}

std::string FormatJoints(const google::protobuf::RepeatedField<double>& values) {
  return absl::StrJoin(values, " ", [](std::string* text, double value) {
    absl::StrAppend(text, FormatFixed(value, kDecimals));
  });
}

}  // namespace cwm::cli
