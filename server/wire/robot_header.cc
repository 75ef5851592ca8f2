#include "server/wire/robot_header.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/robot/kinematics.h"
#include "collision/robot/state_range.h"
#include "collision/world/apply_fault.h"
#include "collision/world/robot_state.h"
#include "collision/xml/xml_element.h"
#include "server/wire/numbers.h"
#include "server/wire/objects.h"
#include "server/wire/poses.h"
#include "server/wire/robot_settings.h"

namespace cwm::server {
namespace {

using Files = std::map<std::string, std::string, std::less<>>;

// Gets the text, or the contents of the file that it names.
absl::Status TakeText(const TextSource& source, Files& files, const FieldPath& path,
                      std::string* text) {
  if (source.file.empty()) {
    *text = source.text;
    return absl::OkStatus();
  }
  const auto file = files.find(source.file);
  if (file == files.end()) {
    return path.Error(absl::StrCat("is ", collision::Quoted(source.file),
                                   ", must be the name of one of the files sent along"));
  }
  *text = file->second;  // a copy, since the same file may be named twice
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<RobotPlan> RobotPlanFromProto(const v1::LoadRobotHeader& header,
                                             const FieldPath& path) {
  RobotPlan plan;
  plan.world = header.world();
  plan.world_uid = header.world_uid();
  if (!header.name().empty()) {
    if (auto status = CheckName(header.name(), path.Field("name")); !status.ok()) return status;
    plan.name = header.name();
  }
  plan.urdf = {header.urdf(), header.urdf_file()};
  if (plan.urdf.text.empty() && plan.urdf.file.empty()) {
    return path.Field("urdf").Error("is empty, must be given, or urdf_file be");
  }
  if (header.srdf_source_case() != v1::LoadRobotHeader::SRDF_SOURCE_NOT_SET) {
    plan.srdf = TextSource{header.srdf(), header.srdf_file()};
  }
  if (header.spheres_source_case() != v1::LoadRobotHeader::SPHERES_SOURCE_NOT_SET) {
    plan.spheres = TextSource{header.spheres(), header.spheres_file()};
  }
  if (header.has_x_world_base()) {
    auto X_WB = PoseFromProto(header.x_world_base(), path.Field("x_world_base"));
    if (!X_WB.ok()) return X_WB.status();
    plan.X_WB = *X_WB;
  }
  auto joints = JointValuesFromProto(header.initial_state(), path.Field("initial_state"));
  if (!joints.ok()) return joints.status();
  plan.initial_state = *std::move(joints);
  auto settings = RobotSettingsFromProto(header, path);
  if (!settings.ok()) return settings.status();
  plan.settings = *std::move(settings);
  plan.write.request_id = header.request_id();
  if (header.has_expected_revision()) {
    plan.write.expected_revision = collision::Revision{header.expected_revision()};
  }
  return plan;
}

absl::StatusOr<RobotFiles> MakeRobotFiles(const RobotPlan& plan, Files files,
                                          const FieldPath& path) {
  RobotFiles result;
  auto status = TakeText(plan.urdf, files, path.Field("urdf_file"), &result.urdf);
  if (status.ok() && plan.srdf.has_value()) {
    status = TakeText(*plan.srdf, files, path.Field("srdf_file"), &result.srdf.emplace());
  }
  if (status.ok() && plan.spheres.has_value()) {
    status = TakeText(*plan.spheres, files, path.Field("spheres_file"), &result.spheres.emplace());
  }
  if (!status.ok()) return status;
  result.meshes = std::move(files);
  result.settings = plan.settings;
  return result;
}

absl::StatusOr<collision::PutRobot> MakePutRobot(
    const RobotPlan& plan, std::shared_ptr<const collision::RobotGeometry> robot,
    const FieldPath& path) {
  const collision::RobotModel& model = *robot->model;
  collision::PutRobot put;
  put.name = plan.name.empty() ? model.name : plan.name;
  if (!collision::IsValidName(put.name)) {
    return path.Field("name").Error(
        absl::StrCat("is empty, must be given: that of the URDF, ", collision::Quoted(put.name),
                     ", is not made of 1 to 128 letters, digits and _-./"));
  }
  auto state = collision::StateWith(model, collision::DefaultVariables(model), plan.initial_state);
  if (!state.ok()) {
    const auto fault = collision::FieldRuleOf(state.status());
    if (!fault.has_value()) return state.status();
    const FieldPath initial_state = path.Field("initial_state");
    return initial_state.Field(fault->field).Error(fault->rule);
  }
  if (auto fault = collision::StateFault(model, plan.X_WB, *state)) {
    return path.Field("initial_state").Error(*std::move(fault));
  }
  put.state = *std::move(state);
  put.X_WB = plan.X_WB;
  put.robot = std::move(robot);
  return put;
}

}  // namespace cwm::server
