// cwm import
#include <algorithm>
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
#include "clients/cli/scene_objects.h"
#include "clients/cli/scene_robot.h"
#include "clients/cpp/geometry_transfer.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/format_error.h"
#include "clients/formats/scene_file.h"
#include "proto/transfer/mesh_bytes.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using formats::SceneAttachedObject;
using formats::SceneFile;
using formats::SceneObject;

// A planning scene is text of some kilobytes; this is a mesh-laden one many times over.
constexpr std::int64_t kMaxSceneBytes = 64 << 20;

enum class Part { kState = 1, kAllowed, kAttached };

struct ImportArguments {
  std::string file, robot, world_frame;
  std::vector<Part> without;
  ChangeArguments change;

  bool Takes(Part part) const {
    return std::find(without.begin(), without.end(), part) == without.end();
  }
};

// What is taken of a scene, for the user to read and the server to do.
struct Plan {
  std::vector<pb::Change> changes;
  std::vector<std::string> taken;
  std::vector<std::string> warnings;
};

std::string Counted(std::size_t count, const std::string& what) {
  return absl::StrCat(count, " ", what, count == 1 ? "" : "s");
}

bool NeedsRobot(const SceneFile& scene, const ImportArguments& arguments) {
  return (arguments.Takes(Part::kState) && !scene.robot_state.empty()) ||
         (arguments.Takes(Part::kAttached) && !scene.robot_state.attached.empty()) ||
         (arguments.Takes(Part::kAllowed) &&
          (!scene.allowed_collisions.names.empty() || !scene.allowed_collisions.defaults.empty()));
}

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

absl::Status PlanState(const SceneFile& scene, const pb::Robot& robot, Plan& plan) {
  if (scene.robot_state.empty()) return absl::OkStatus();
  SceneState state = StateOf(scene.robot_state, robot);
  const int count = state.set.joints().values_size();
  plan.warnings.insert(plan.warnings.end(), state.warnings.begin(), state.warnings.end());
  if (count == 0 && !state.sets_base) return absl::OkStatus();
  *plan.changes.emplace_back().mutable_robot_state() = std::move(state.set);
  plan.taken.push_back(absl::StrCat("the state of ", robot.name(), " (",
                                    Counted(static_cast<std::size_t>(count), "joint value"),
                                    state.sets_base ? " and its base" : "", ")"));
  return absl::OkStatus();
}

absl::Status PlanObjects(Session& session, const std::vector<const SceneObject*>& objects,
                         Plan& plan) {
  const StoreMesh store = [&session](const formats::MeshFile& mesh) {
    return client::WriteGeometry(session.connection(),
                                 {pb::GEOMETRY_FORMAT_MESH_F64, EncodeMesh(mesh)});
  };
  std::map<std::string, std::string> id_of_name;
  std::size_t meshes = 0;
  for (const SceneObject* scene_object : objects) {
    auto object = ToObject(*scene_object, store);
    if (!object.ok()) return object.status();
    const auto [known, is_new] = id_of_name.emplace(object->name(), scene_object->id);
    if (!is_new) {
      return absl::InvalidArgumentError(absl::StrCat(
          "ids \"", formats::Printable(known->second), "\" and \"",
          formats::Printable(scene_object->id), "\" would both be \"",
          formats::Printable(object->name()), "\", must differ in letters, digits and _-./"));
    }
    if (object->name() != scene_object->id) {
      plan.warnings.push_back(absl::StrCat("\"", formats::Printable(scene_object->id),
                                           "\": put as ", formats::Printable(object->name()),
                                           ", names have letters, digits and _-./"));
    }
    for (const auto& shape : scene_object->shapes) {
      meshes += std::holds_alternative<formats::MeshFile>(shape.shape) ? 1 : 0;
    }
    *plan.changes.emplace_back().mutable_put()->mutable_object() = *std::move(object);
  }
  if (!objects.empty()) {
    const std::string of_meshes =
        meshes == 0 ? "" : absl::StrCat(" (", meshes, meshes == 1 ? " mesh)" : " meshes)");
    plan.taken.push_back(absl::StrCat(Counted(objects.size(), "object"), of_meshes));
  }
  return absl::OkStatus();
}

void PlanRules(const SceneFile& scene, const pb::Robot* robot, Plan& plan) {
  SceneRules rules = RulesOf(scene, robot);
  plan.warnings.insert(plan.warnings.end(), rules.warnings.begin(), rules.warnings.end());
  if (rules.pairs.empty()) return;
  for (const pb::NamedPair& pair : rules.pairs) {
    *plan.changes.emplace_back().mutable_allow()->mutable_pair() = pair;
  }
  plan.taken.push_back(Counted(rules.pairs.size(), "allowed pair"));
}

// Whether the file says where in the world it is, whatever the robot may be.
bool StandsInWorld(const SceneAttachedObject& attached) {
  return !attached.pose_is_in_link || attached.object.shapes.empty();
}

void PlanAttached(const SceneAttachedObject& attached, const pb::Robot& robot, Plan& plan) {
  pb::AttachObject& attach = *plan.changes.emplace_back().mutable_attach();
  attach.set_name(WorldName(attached.object.id));
  attach.set_robot(robot.name());
  attach.set_link(attached.link);
  std::vector<std::string> unknown;
  for (const std::string& link : attached.touch_links) {
    if (HasLink(robot, link)) {
      attach.add_touch_links(link);
    } else {
      unknown.push_back(link);
    }
  }
  if (!unknown.empty()) {
    plan.warnings.push_back(absl::StrCat(formats::Printable(attached.object.id), ": touch_links ",
                                         Listed(unknown), ": left out, ", robot.name(),
                                         " has no such links"));
  }
  // Put in the frame of the link, it goes where that is; else it stays where it was put.
  if (StandsInWorld(attached)) return;
  const auto put = std::find_if(plan.changes.begin(), plan.changes.end(), [&](const auto& c) {
    return c.has_put() && c.put().object().name() == attach.name();
  });
  *attach.mutable_x_link_object() = put->put().object().x_world_object();
}

void PlanAttached(const SceneFile& scene, const pb::Robot& robot, Plan& plan) {
  std::size_t count = 0;
  for (const SceneAttachedObject& attached : scene.robot_state.attached) {
    if (HasLink(robot, attached.link)) {
      PlanAttached(attached, robot, plan);
      ++count;
      continue;
    }
    plan.warnings.push_back(absl::StrCat(
        formats::Printable(attached.object.id),
        StandsInWorld(attached) ? ": stands free, " : ": left out with its pose in that link, ",
        robot.name(), " has no link ", formats::Printable(attached.link), " to hold it"));
  }
  if (count > 0) plan.taken.push_back(Counted(count, "attached object"));
}

absl::StatusOr<Plan> MakePlan(Session& session, const SceneFile& scene,
                              const ImportArguments& arguments) {
  Plan plan;
  plan.warnings = scene.warnings;
  std::optional<pb::Robot> robot;
  if (NeedsRobot(scene, arguments)) {
    auto found = FindRobot(session, arguments.robot);
    if (!found.ok()) return found.status();
    robot = *std::move(found);
    if (!robot) {
      plan.warnings.push_back(
          "the world has no robot: its state, what it holds and what its links may touch are left "
          "out; `cwm robot load` it first");
    } else if (!scene.robot_model_name.empty() && robot->name() != scene.robot_model_name) {
      plan.warnings.push_back(absl::StrCat("the scene is of ",
                                           formats::Printable(scene.robot_model_name),
                                           ", taken for ", robot->name()));
    }
  }
  const bool attaches = robot && arguments.Takes(Part::kAttached);
  std::vector<const SceneObject*> objects;
  for (const SceneObject& object : scene.objects) objects.push_back(&object);
  for (const SceneAttachedObject& attached : scene.robot_state.attached) {
    if (!attaches || attached.object.shapes.empty()) continue;
    if (StandsInWorld(attached) || HasLink(*robot, attached.link)) {
      objects.push_back(&attached.object);
    }
  }
  absl::Status status;
  if (robot && arguments.Takes(Part::kState)) status = PlanState(scene, *robot, plan);
  if (status.ok()) status = PlanObjects(session, objects, plan);
  if (!status.ok()) return status;
  if (arguments.Takes(Part::kAllowed)) PlanRules(scene, robot ? &*robot : nullptr, plan);
  if (attaches) PlanAttached(scene, *robot, plan);
  return plan;
}

absl::Status Import(Session& session, const ImportArguments& arguments) {
  const auto bytes = formats::ReadFileBytes(arguments.file, kMaxSceneBytes);
  if (!bytes.ok()) return bytes.status();
  const auto scene =
      formats::ParseScene(*bytes, arguments.file, {.world_frame = arguments.world_frame});
  if (!scene.ok()) return scene.status();
  const auto plan = MakePlan(session, *scene, arguments);
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
