// cwm import
#include <map>
#include <memory>
#include <optional>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/all_pages.h"
#include "clients/cli/change_arguments.h"
#include "clients/cli/commands.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/one_of.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/scene_file.h"
#include "clients/scene/scene_import.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using scene::Part;

// A planning scene is text of some kilobytes; this is a mesh-laden one many times over.
constexpr std::int64_t kMaxSceneBytes = 64 << 20;

struct ImportArguments {
  std::string file, robot, world_frame;
  std::vector<Part> without;
  ChangeArguments change;
};

// The robot that is named, or the only one of the world; nothing where there is none.
absl::StatusOr<std::optional<pb::Robot>> FindRobot(Session& session, const std::string& name) {
  pb::ListRobotsRequest request;
  request.set_world(session.world);
  request.set_name(name);
  const auto found = AllPages<pb::ListRobotsResponse>(session, &pb::RobotService::Stub::ListRobots,
                                                      session.connection().robots(), request);
  if (!found.ok() && name.empty() && absl::IsNotFound(found.status())) {
    return std::nullopt;  // the import makes the world
  }
  if (!found.ok()) return found.status();
  if (found->robots().empty()) return std::nullopt;
  if (found->robots_size() == 1) return found->robots(0);
  std::vector<std::string> names;
  for (const pb::Robot& robot : found->robots()) names.push_back(robot.name());
  return UsageError(absl::StrCat("--robot must say whose scene it is: the world has ",
                                 absl::StrJoin(names, ", ")));
}

absl::Status Import(Session& session, const ImportArguments& arguments) {
  const auto bytes = formats::ReadFileBytes(arguments.file, kMaxSceneBytes);
  if (!bytes.ok()) return bytes.status();
  const auto file =
      formats::ParseScene(*bytes, arguments.file, {.world_frame = arguments.world_frame});
  if (!file.ok()) return file.status();
  scene::ImportOptions options{.robot = nullptr, .without = arguments.without};
  std::optional<pb::Robot> robot;
  if (scene::NeedsRobot(*file, options)) {
    auto found = FindRobot(session, arguments.robot);
    if (!found.ok()) return found.status();
    robot = *std::move(found);
    if (robot) options.robot = &*robot;
  }
  const auto plan = scene::ImportOf(session.connection(), *file, options);
  if (!plan.ok()) return plan.status();
  for (const std::string& warning : plan->warnings) session.Warn(warning);
  if (plan->changes.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(arguments.file, ": holds nothing to import"));
  }
  return Apply(session, arguments.change, plan->changes,
               absl::StrCat("imported ", absl::StrJoin(plan->taken, ", ")));
}

}  // namespace

void AddImportCommand(CommandLine& line) {
  static const std::map<std::string, Part> kParts = {
      {"state", Part::kState}, {"allowed", Part::kAllowed}, {"attached", Part::kAttached}};
  const auto arguments = std::make_shared<ImportArguments>();
  CLI::App& command = AddCommand(
      line,
      {"import",
       "a MoveIt planning scene (YAML or .scene), in one revision",
       {"cwm import scene0001.yaml", "cwm import shelf.scene --world shelf",
        "cwm import scene0001.yaml --robot panda --without state"},
       "Objects are put under their ids: boxes, cylinders, spheres, cones, meshes, and planes as\n"
       "half-spaces, solid where the normal points away from. Of YAML also the state of the robot, "
       "its base,\nwhat it holds and which pairs may collide: for these the world must have the "
       "robot.\nWhat is left out is said in warnings. A file has at most 64 MiB."},
      [arguments](Session& session) { return Import(session, *arguments); });
  command.add_option("SCENE", arguments->file, "a YAML or .scene file")->required();
  command
      .add_option("--robot", arguments->robot,
                  "whose state it is; default: the only robot of the world")
      ->type_name("NAME");
  command
      .add_option("--without", arguments->without,
                  "leave out the robot's state, the allowed pairs, attached objects; repeatable")
      ->transform(OneOf(kParts))
      ->allow_extra_args(false)
      ->type_name("state|allowed|attached");
  command
      .add_option("--world-frame", arguments->world_frame,
                  "a frame of the file that is the world's, besides \"world\"")
      ->type_name("FRAME");
  AddChangeOptions(command, arguments->change);
}

}  // namespace cwm::cli
