// cwm import
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/all_pages.h"
#include "clients/cli/change_arguments.h"
#include "clients/cli/commands.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/mesh_arguments.h"
#include "clients/cli/number_list.h"
#include "clients/cli/one_of.h"
#include "clients/cli/pose_argument.h"
#include "clients/cli/progress.h"
#include "clients/cli/scan_arguments.h"
#include "clients/cli/scan_ingest.h"
#include "clients/formats/cloud_reader.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/scene_file.h"
#include "clients/meshes/mesh_reading.h"
#include "clients/scene/scene_import.h"
#include "clients/scene/scene_objects.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using scene::ScenePart;

// chosen: a planning scene is text of a few kilobytes; this is many times a scene full of meshes.
constexpr std::size_t kMaxSceneBytes = std::size_t{64} << 20;

// Kinds of files, and the names of the option groups that apply to them.
constexpr char kCloud[] = "Clouds", kMesh[] = "Meshes", kScene[] = "Scenes";
constexpr char kCloudOrMesh[] = "Clouds and meshes";

struct ImportArguments {
  std::string file, robot, world_frame, name, at = "0,0,0";
  std::vector<ScenePart> without;
  bool replaces = false;
  MeshArguments mesh;
  ScanArguments scan;
  ChangeArguments change;
};

std::string ExtensionOf(const std::string& file) {
  return absl::AsciiStrToLower(std::filesystem::path(file).extension().string());
}

// The kind by the first bytes if they reveal it, otherwise by the name's ending. Unknown files are
// treated as scenes, whose reader reports the error.
const char* ContentOf(std::string_view bytes, const std::string& file) {
  if (meshes::IsMesh(bytes, file)) return kMesh;
  const std::string ending = ExtensionOf(file);
  if (ending == ".scene" || ending == ".yaml" || ending == ".yml") return kScene;
  for (const char* cloud : {".pcd", ".ply", ".xyz", ".npy", ".asc", ".csv", ".txt"}) {
    if (ending == cloud) return kCloud;
  }
  return formats::DetectCloudFormat(bytes) ? kCloud : kScene;
}

std::string NameOf(const std::string& content) {
  if (content == kCloud) return "a cloud";
  return content == kMesh ? "a mesh" : "a planning scene";
}

// A usage error for options that do not apply to the file's kind.
absl::Status CheckOptions(const CLI::App& command, const ImportArguments& arguments,
                          const std::string& content) {
  for (const CLI::Option* option : command.get_options()) {
    const std::string& group = option->get_group();
    const bool of_files =
        group == kCloud || group == kMesh || group == kScene || group == kCloudOrMesh;
    const bool of_changes = option->check_name("--expected-revision");
    const bool fits =
        of_changes ? content != kCloud
                   : !of_files || group == content || (group == kCloudOrMesh && content != kScene);
    if (option->count() == 0 || fits) continue;
    return UsageError(absl::StrCat(option->get_name(), " does not go with ", arguments.file,
                                   ", which is read as ", NameOf(content)));
  }
  return absl::OkStatus();
}

absl::Status ImportCloud(Session& session, const ImportArguments& arguments,
                         std::string_view bytes) {
  auto header = ParseScanHeader(arguments.scan, session);
  if (!header.ok()) return header.status();
  header->set_mode(pb::INGEST_MODE_UPDATE);
  header->set_request_id(arguments.change.request_id);
  if (arguments.mesh.scale != 1) header->set_scale(arguments.mesh.scale);
  return IngestScan(session, arguments.scan, *header, {.bytes = bytes, .name = arguments.file});
}

absl::Status ImportMesh(Session& session, const ImportArguments& arguments,
                        std::string_view bytes) {
  const auto pose = ParsePoseArgument(session, arguments.at, "--at");
  if (!pose.ok()) return pose.status();
  const auto mesh = SendMeshFile(session, bytes, arguments.file, arguments.mesh);
  if (!mesh.ok()) return mesh.status();
  pb::Change change;
  pb::Object& object = *change.mutable_put()->mutable_object();
  object.set_name(arguments.name.empty()
                      ? scene::ObjectName(std::filesystem::path(arguments.file).stem().string())
                      : arguments.name);
  object.set_kind(pb::OBJECT_KIND_USER);
  *object.mutable_x_world_object() = PoseToProto(*pose);
  *object.add_shapes() = mesh->part;
  return Apply(session, arguments.change, {change},
               absl::StrCat("imported ", object.name(), ", ", mesh->text));
}

// The named robot, or the only one of the world; empty if there is none.
absl::StatusOr<std::optional<pb::Robot>> FindRobotToImport(Session& session,
                                                           const std::string& name) {
  pb::ListRobotsRequest request;
  request.set_world(session.world);
  request.set_name(name);
  const auto found = ListAllPages<pb::ListRobotsResponse>(
      session, &pb::RobotService::Stub::ListRobots, session.connection().robots(), request);
  if (!found.ok() && name.empty() && absl::IsNotFound(found.status())) {
    return std::nullopt;  // the import will create the world
  }
  if (!found.ok()) return found.status();
  if (found->robots().empty()) return std::nullopt;
  if (found->robots_size() == 1) return found->robots(0);
  std::vector<std::string> names;
  for (const pb::Robot& robot : found->robots()) names.push_back(robot.name());
  return UsageError(absl::StrCat("--robot must say whose scene it is: the world has ",
                                 absl::StrJoin(names, ", ")));
}

absl::StatusOr<std::vector<pb::PairRule>> RulesOfWorld(Session& session) {
  pb::GetWorldRequest request;
  request.set_world(session.world);
  const client::Connection& connection = session.connection();
  const auto world =
      connection.Call(&pb::WorldService::Stub::GetWorld, connection.worlds(), request);
  if (absl::IsNotFound(world.status())) return std::vector<pb::PairRule>();
  if (!world.ok()) return world.status();
  return std::vector<pb::PairRule>(world->pair_rules().begin(), world->pair_rules().end());
}

// The names of objects put by users, which includes imported ones.
absl::StatusOr<std::vector<std::string>> ObjectsPut(Session& session) {
  pb::ListObjectsRequest request;
  request.set_world(session.world);
  request.set_view(pb::OBJECT_VIEW_BASIC);
  request.add_kinds(pb::OBJECT_KIND_USER);
  const auto found = ListAllPages<pb::ListObjectsResponse>(
      session, &pb::WorldService::Stub::ListObjects, session.connection().worlds(), request);
  if (absl::IsNotFound(found.status())) return std::vector<std::string>();
  if (!found.ok()) return found.status();
  std::vector<std::string> names;
  for (const pb::Object& object : found->objects()) names.push_back(object.name());
  return names;
}

// Shows progress. A mesh that the server has already is not sent to its end.
absl::StatusOr<scene::SceneImport> SendScene(Session& session, const formats::SceneFile& file,
                                             scene::ImportOptions options) {
  Progress progress(session);
  options.progress = [&progress](const scene::MeshUploadProgress& sent) {
    const std::string what = absl::StrCat("mesh ", sent.mesh, " of ", sent.meshes);
    if (sent.sent_bytes >= sent.total_bytes) return progress.ShowStage("the server stores " + what);
    progress.Update({.action = "sending",
                     .moved_bytes = sent.sent_bytes,
                     .total_bytes = sent.total_bytes,
                     .detail = what});
  };
  return scene::ConvertScene(session.connection(), file, options);
}

absl::Status ImportScene(Session& session, const ImportArguments& arguments,
                         std::string_view bytes) {
  if (bytes.size() > kMaxSceneBytes) {
    return absl::InvalidArgumentError(absl::StrCat(arguments.file, ": size is ", bytes.size(),
                                                   " bytes, must be at most ", kMaxSceneBytes));
  }
  const auto file =
      formats::ParseScene(bytes, arguments.file, {.world_frame = arguments.world_frame});
  if (!file.ok()) return file.status();
  scene::ImportOptions options{.excluded = arguments.without};
  std::optional<pb::Robot> robot;
  if (scene::NeedsRobot(*file, options)) {
    auto found = FindRobotToImport(session, arguments.robot);
    if (!found.ok()) return found.status();
    robot = *std::move(found);
    if (robot) options.robot = &*robot;
    auto rules = RulesOfWorld(session);
    if (!rules.ok()) return rules.status();
    options.rules = *std::move(rules);
  }
  if (arguments.replaces) options.previous = scene::PreviousObjects::kRemove;
  if (arguments.replaces || !file->removed.empty()) {
    auto objects = ObjectsPut(session);
    if (!objects.ok()) return objects.status();
    options.objects = *std::move(objects);
  }
  const auto plan = SendScene(session, *file, options);
  if (!plan.ok()) return plan.status();
  for (const std::string& warning : plan->warnings) session.Warn(warning);
  if (plan->changes.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(arguments.file, ": holds nothing to import"));
  }
  return Apply(session, arguments.change, plan->changes,
               absl::StrCat("imported ", absl::StrJoin(plan->imported, ", ")));
}

absl::Status Import(Session& session, const CLI::App& command, const ImportArguments& arguments) {
  const auto bytes = formats::ReadFileBytes(arguments.file);
  if (!bytes.ok()) return bytes.status();
  const std::string content = ContentOf(*bytes, arguments.file);
  if (absl::Status status = CheckOptions(command, arguments, content); !status.ok()) return status;
  if (content == kCloud) return ImportCloud(session, arguments, *bytes);
  if (content == kMesh) return ImportMesh(session, arguments, *bytes);
  return ImportScene(session, arguments, *bytes);
}

}  // namespace

void AddImportCommand(CommandLine& line) {
  static const std::map<std::string, ScenePart> kParts = {{"state", ScenePart::kState},
                                                          {"allowed", ScenePart::kAllowed},
                                                          {"attached", ScenePart::kAttached}};
  const auto arguments = std::make_shared<ImportArguments>();
  // The action checks which options were given.
  const auto self = std::make_shared<const CLI::App*>();
  CLI::App& command = AddCommand(
      line,
      {"import",
       "files of other tools: scans, meshes, MoveIt's planning scenes",
       {"cwm import scan.npy --up 0,-1,0", "cwm import cup.stl --scale 0.001 --at 0.6,0,0.8",
        "cwm import chair.glb --name kitchen/chair", "cwm import scene0001.yaml",
        "cwm import shelf.scene --world shelf",
        "cwm import scene0001.yaml --robot panda --without state"},
       "What a file is, its first bytes say, or else its ending.\n"
       "Clouds: PCD, PLY without faces, XYZ (text, also .csv .txt .asc), NPY. A scan as for `cwm "
       "ingest`, which\nhas more options.\n"
       "Meshes: STL, OBJ, PLY with faces, DAE, GLB. One object, named as the file, of all that "
       "the file draws,\nsolid where watertight. Units are metres; the unit of a DAE is applied. "
       "Z is up; of GLB it is Y,\nof DAE what it says.\n"
       "Scenes: YAML or .scene. Objects are put under their ids, in one revision: boxes, "
       "cylinders, spheres,\ncones, meshes, and planes as half-spaces, solid where the normal "
       "points away from. Of YAML also the\nstate of the robot, its base, what it holds and which "
       "pairs may collide: for these the world must\nhave the robot. What was allowed before ends "
       "where the scene says false to it, and links that the SRDF\ndisables are then checked; all "
       "else of before stays, unless --replace is given. A scene that only says\nwhat differs "
       "(is_diff) may remove objects. "
       "What is left out is said in warnings, and where\n"
       "the scene and the robot's SRDF differ about links. A scene has at most 64 MiB."},
      [arguments, self](Session& session) { return Import(session, **self, *arguments); });
  *self = &command;
  command.add_option("FILE", arguments->file, "a cloud, a mesh or a planning scene")->required();
  command
      .add_option("--name", arguments->name, "of the object; default: the file's, without ending")
      ->type_name("NAME")
      ->group(kMesh);
  command.add_option("--at", arguments->at, "its pose in the world (m); default: the origin")
      ->type_name(kPoseArgumentForm)
      ->group(kMesh);
  AddMeshOptions(command, kMesh, arguments->mesh);
  command.get_option("--scale")->description("metres per unit: 0.001 for millimetres");
  command.get_option("--scale")->group(kCloudOrMesh);
  const std::size_t before_scan = command.get_options().size();
  AddScanOptions(command, arguments->scan);
  const std::vector<CLI::Option*> options = command.get_options({});
  for (std::size_t i = before_scan; i < options.size(); ++i) options[i]->group(kCloud);
  command
      .add_option("--robot", arguments->robot,
                  "whose state it is; default: the only robot of the world")
      ->type_name("NAME")
      ->group(kScene);
  command
      .add_option("--without", arguments->without,
                  "leave out the robot's state, the allowed pairs, attached objects; repeatable")
      ->transform(OneOf(kParts))
      ->allow_extra_args(false)
      ->type_name("state|allowed|attached")
      ->group(kScene);
  command
      .add_flag("--replace", arguments->replaces,
                "remove what users and imports put before, and end what was allowed, unless the "
                "scene has it too")
      ->group(kScene);
  command
      .add_option("--world-frame", arguments->world_frame,
                  "a frame of the file that is the world's, besides \"world\"")
      ->type_name("FRAME")
      ->group(kScene);
  AddChangeOptions(command, arguments->change);
}

}  // namespace cwm::cli
