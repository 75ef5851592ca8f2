#include "clients/cli/robot_load_command.h"

#include <filesystem>
#include <memory>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "clients/cli/change_arguments.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/link_values.h"
#include "clients/cli/number_list.h"
#include "clients/cli/pose_argument.h"
#include "clients/cli/progress.h"
#include "clients/cli/robot_table.h"
#include "clients/cpp/robot_upload.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/robot_files.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

struct LoadArguments {
  std::string urdf, srdf, spheres, name, at;
  std::vector<std::string> package_folders;
  std::vector<std::string> paddings, scales, tools, tool_groups;  // see link_values.h
  ChangeArguments change;
};

absl::Status SetToolGroup(const std::string& text, pb::LoadRobotHeader& header) {
  const auto named = ParseToolGroup(text);
  if (!named.ok()) return named.status();
  for (pb::RobotTool& tool : *header.mutable_tools()) {
    if (tool.name() != named->first) continue;
    tool.set_group(named->second);
    return absl::OkStatus();
  }
  return UsageError(
      absl::StrCat("--tool-group: \"", named->first, "\" must be the name of a --tool"));
}

absl::Status SetSettings(const LoadArguments& arguments, pb::LoadRobotHeader& header) {
  for (const std::string& text : arguments.paddings) {
    const auto padding = ParseLinkPadding(text);
    if (!padding.ok()) return padding.status();
    *header.add_link_padding() = *padding;
  }
  for (const std::string& text : arguments.scales) {
    const auto scale = ParseLinkScale(text);
    if (!scale.ok()) return scale.status();
    *header.add_link_scale() = *scale;
  }
  for (const std::string& text : arguments.tools) {
    const auto tool = ParseTool(text);
    if (!tool.ok()) return tool.status();
    *header.add_tools() = *tool;
  }
  for (const std::string& text : arguments.tool_groups) {
    if (auto status = SetToolGroup(text, header); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<pb::LoadRobotHeader> ParseRobotHeader(const LoadArguments& arguments,
                                                     Session& session) {
  pb::LoadRobotHeader header;
  header.set_world(session.world);
  header.set_name(arguments.name);
  auto text = formats::ReadFileBytes(arguments.urdf);
  if (!text.ok()) return text.status();
  header.set_urdf(*std::move(text));
  if (!arguments.srdf.empty()) {
    if (text = formats::ReadFileBytes(arguments.srdf); !text.ok()) return text.status();
    header.set_srdf(*std::move(text));
  }
  if (!arguments.spheres.empty()) {
    if (text = formats::ReadFileBytes(arguments.spheres); !text.ok()) return text.status();
    header.set_spheres(*std::move(text));
  }
  if (!arguments.at.empty()) {
    const auto pose = ParsePoseArgument(session, arguments.at, "--at");
    if (!pose.ok()) return pose.status();
    *header.mutable_x_world_base() = PoseToProto(*pose);
  }
  if (auto status = SetSettings(arguments, header); !status.ok()) return status;
  header.set_request_id(arguments.change.request_id);
  if (arguments.change.expected_revision) {
    header.set_expected_revision(*arguments.change.expected_revision);
  }
  return header;
}

absl::StatusOr<std::vector<client::RobotFile>> ReadMeshes(const LoadArguments& arguments,
                                                          const std::string& urdf) {
  const formats::RobotFolders folders{
      .urdf_folder = std::filesystem::path(arguments.urdf).parent_path().string(),
      .package_folders = arguments.package_folders};
  std::vector<client::RobotFile> files;
  for (const std::string& uri : formats::CollisionMeshUris(urdf)) {
    const auto path = formats::FindMeshFile(uri, folders);
    if (!path.ok()) {
      return absl::Status(path.status().code(),
                          absl::StrCat(std::string(path.status().message()),
                                       "; name the folder that holds the package with "
                                       "--package-dir"));
    }
    auto bytes = formats::ReadFileBytes(*path);
    if (!bytes.ok()) return bytes.status();
    files.push_back({uri, *std::move(bytes)});
  }
  return files;
}

absl::StatusOr<pb::LoadRobotResponse> Send(Session& session, const pb::LoadRobotHeader& header,
                                           const std::vector<client::RobotFile>& files) {
  Progress progress(session);
  const std::string meshes = absl::StrCat(files.size(), " meshes");
  const auto show = [&](std::int64_t sent, std::int64_t total) {
    if (sent >= total)
      return progress.ShowStage(absl::StrCat("the server reads ", files.size(), " meshes"));
    progress.Update(
        {.action = "sending", .moved_bytes = sent, .total_bytes = total, .detail = meshes});
  };
  return client::LoadRobot(session.connection(), header, files, show);
}

absl::Status Load(Session& session, const LoadArguments& arguments) {
  const auto header = ParseRobotHeader(arguments, session);
  if (!header.ok()) return header.status();
  const auto files = ReadMeshes(arguments, header->urdf());
  if (!files.ok()) return files.status();
  const auto response = Send(session, *header, *files);
  if (!response.ok()) return response.status();
  session.Print(*response, [&] {
    PrintRobotDetails(response->robot(), session.table_style(), session.streams.out);
    session.streams.out << "revision " << response->revision() << "\n";
    for (const std::string& warning : response->warnings()) session.Warn(warning);
  });
  return absl::OkStatus();
}

}  // namespace

void AddRobotLoadCommand(CommandLine& line, CLI::App& family) {
  const auto arguments = std::make_shared<LoadArguments>();
  CLI::App& command = AddCommand(
      line, family,
      {"load",
       "a robot from its URDF, or another one in its place",
       {"cwm robot load panda.urdf --srdf panda.srdf",
        "cwm robot load robot.urdf --package-dir ~/ros/src --name left --at 0,0.5,0",
        "cwm robot load panda.urdf --srdf panda.srdf --padding '*=0.01' --tool "
        "grip=panda_hand@0,0,0.1034 --tool-group grip=panda_arm"},
       "Meshes are sent along. Those of \"package://PACKAGE/REST\" are PACKAGE/REST below a "
       "--package-dir,\n"
       "or REST below one that is PACKAGE by its name or its package.xml; without a --package-dir, "
       "of the\n"
       "folder of the URDF and the three above it. Expand xacro first:\n"
       "xacro robot.urdf.xacro > robot.urdf"},
      [arguments](Session& session) { return Load(session, *arguments); });
  command.add_option("URDF", arguments->urdf, "the robot's links and joints")->required();
  command.add_option("--srdf", arguments->srdf, "groups, named states, pairs that are not checked")
      ->type_name("FILE");
  command
      .add_option("--spheres", arguments->spheres,
                  "a URDF of the same links made of spheres: the robot's sphere model")
      ->type_name("FILE");
  command
      .add_option("--package-dir", arguments->package_folders,
                  "holds packages, or is one; repeatable")
      ->allow_extra_args(false)
      ->type_name("DIR");
  command
      .add_option("--padding", arguments->paddings,
                  "an extra margin of the link ('*': of all others) against the world, not against "
                  "the robot itself (m); repeatable")
      ->allow_extra_args(false)
      ->type_name(kPaddingForm);
  command
      .add_option("--scale", arguments->scales,
                  "multiplies the link's collision geometry about its own origin ('*': of all "
                  "others); repeatable")
      ->allow_extra_args(false)
      ->type_name(kScaleForm);
  command
      .add_option("--tool", arguments->tools,
                  "a frame in which a tool acts, in that of its link (m); repeatable")
      ->allow_extra_args(false)
      ->type_name(kToolForm);
  command
      .add_option("--tool-group", arguments->tool_groups,
                  "the group that moves the tool: `cwm solve` uses it by default; repeatable")
      ->allow_extra_args(false)
      ->type_name(kToolGroupForm);
  command.add_option("--name", arguments->name, "in the world; default: the URDF's")
      ->type_name("NAME");
  CLI::Option* const at =
      command
          .add_option("--at", arguments->at, "its root link in the world (m); default: the origin")
          ->type_name(kPoseArgumentForm);
  AddFormerName(command, "--x-world-base", arguments->at, at);
  AddChangeOptions(command, arguments->change);
}

}  // namespace cwm::cli
