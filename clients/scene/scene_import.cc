#include "clients/scene/scene_import.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cpp/geometry_transfer.h"
#include "clients/formats/format_error.h"
#include "clients/scene/scene_objects.h"
#include "clients/scene/scene_robot.h"
#include "proto/transfer/mesh_bytes.h"

namespace cwm::scene {
namespace {

namespace pb = cwm::v1;
using formats::SceneAttachedObject;
using formats::SceneFile;
using formats::SceneObject;

std::string FormatCount(std::size_t count, const std::string& what) {
  return absl::StrCat(count, " ", what, count == 1 ? "" : "s");
}

absl::Status PlanState(const SceneFile& scene, const pb::Robot& robot, SceneImport& plan) {
  if (scene.robot_state.empty()) return absl::OkStatus();
  SceneState state = ConvertRobotState(scene.robot_state, robot);
  const int count = state.set.joints().values_size();
  plan.warnings.insert(plan.warnings.end(), state.warnings.begin(), state.warnings.end());
  if (count == 0 && !state.sets_base) return absl::OkStatus();
  *plan.changes.emplace_back().mutable_robot_state() = std::move(state.set);
  plan.imported.push_back(absl::StrCat("the state of ", robot.name(), " (",
                                       FormatCount(static_cast<std::size_t>(count), "joint value"),
                                       state.sets_base ? " and its base" : "", ")"));
  return absl::OkStatus();
}

std::int64_t EncodedBytes(const formats::MeshFile& mesh) {
  std::size_t bytes = 0;
  ForEachMeshPiece(mesh, [&bytes](const void*, std::size_t size) { bytes += size; });
  return static_cast<std::int64_t>(bytes);
}

// The state before the first mesh is sent.
MeshUploadProgress InitialProgress(const std::vector<const SceneObject*>& objects) {
  MeshUploadProgress sent;
  for (const SceneObject* object : objects) {
    for (const auto& shape : object->shapes) {
      if (const auto* mesh = std::get_if<formats::MeshFile>(&shape.shape)) {
        ++sent.meshes;
        sent.total_bytes += EncodedBytes(*mesh);
      }
    }
  }
  return sent;
}

// Stores one mesh after the other. `sent` counts all meshes so far and must outlive the result.
StoreMesh MakeMeshStore(const client::Connection& connection, const ImportOptions& options,
                        MeshUploadProgress& sent) {
  return [&connection, &options, &sent](const formats::MeshFile& mesh) {
    ++sent.mesh;
    const std::string bytes = EncodeMesh(mesh);
    const auto size = static_cast<std::int64_t>(bytes.size());
    auto hash = client::WriteGeometry(connection, {pb::GEOMETRY_FORMAT_MESH_F64, bytes},
                                      [&](std::int64_t of_mesh, std::int64_t) {
                                        if (!options.progress) return;
                                        MeshUploadProgress now = sent;
                                        now.sent_bytes += of_mesh;
                                        options.progress(now);
                                      });
    sent.sent_bytes += size;
    return hash;
  };
}

absl::Status PlanObjects(const client::Connection& connection, const ImportOptions& options,
                         const std::vector<const SceneObject*>& objects, SceneImport& plan) {
  MeshUploadProgress sent = InitialProgress(objects);
  const std::size_t meshes = sent.meshes;
  const StoreMesh store = MakeMeshStore(connection, options, sent);
  std::map<std::string, std::string> id_of_name;
  for (const SceneObject* scene_object : objects) {
    auto object = ConvertObject(*scene_object, store);
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
    *plan.changes.emplace_back().mutable_put()->mutable_object() = *std::move(object);
  }
  if (!objects.empty()) {
    const std::string of_meshes =
        meshes == 0 ? "" : absl::StrCat(" (", meshes, meshes == 1 ? " mesh)" : " meshes)");
    plan.imported.push_back(absl::StrCat(FormatCount(objects.size(), "object"), of_meshes));
  }
  return absl::OkStatus();
}

// Removes previous objects: all that the scene does not put, or those that it removes.
void PlanRemovals(const SceneFile& scene, const ImportOptions& options,
                  const std::vector<const SceneObject*>& objects, SceneImport& plan) {
  const std::set<std::string> there(options.objects.begin(), options.objects.end());
  std::set<std::string> gone;
  for (const std::string& id : scene.removed) {
    if (there.count(ObjectName(id)) > 0) {
      gone.insert(ObjectName(id));
    } else {
      plan.warnings.push_back(
          absl::StrCat(formats::Printable(id), ": not removed, no such object was put before"));
    }
  }
  if (options.previous == PreviousObjects::kRemove) {
    gone = there;
    for (const SceneObject* object : objects) gone.erase(ObjectName(object->id));
    // An attachment without shapes refers to an existing object, which must remain.
    for (const SceneAttachedObject& attached : scene.robot_state.attached) {
      gone.erase(ObjectName(attached.object.id));
    }
  }
  for (const std::string& name : gone) {
    plan.changes.emplace_back().mutable_remove()->set_name(name);
  }
  if (!gone.empty())
    plan.imported.push_back(FormatCount(gone.size(), "object") + " of before removed");
}

// The pairs with a previous allowance or check that the scene does not mention.
std::vector<pb::NamedPair> KeptPairs(const std::vector<pb::PairRule>& before,
                                     const SceneRules& rules) {
  const auto has = [](const std::vector<pb::NamedPair>& pairs, const pb::NamedPair& pair) {
    return std::any_of(pairs.begin(), pairs.end(), [&](const pb::NamedPair& other) {
      const auto same = [](const pb::NamedThing& x, const pb::NamedThing& y) {
        return x.name() == y.name() && x.link() == y.link();
      };
      return (same(pair.a(), other.a()) && same(pair.b(), other.b())) ||
             (same(pair.a(), other.b()) && same(pair.b(), other.a()));
    });
  };
  std::vector<pb::NamedPair> kept;
  for (const pb::PairRule& rule : before) {
    const bool is_known = has(rules.pairs, rule.pair()) || has(rules.checked, rule.pair()) ||
                          has(rules.withdrawn, rule.pair());
    if ((rule.allowed() || rule.check()) && !is_known) kept.push_back(rule.pair());
  }
  return kept;
}

void PlanRules(const SceneFile& scene, const ImportOptions& options, SceneImport& plan) {
  SceneRules rules = ConvertRules(scene, options.robot, options.rules);
  plan.warnings.insert(plan.warnings.end(), rules.warnings.begin(), rules.warnings.end());
  const std::vector<pb::NamedPair> kept = KeptPairs(options.rules, rules);
  if (options.previous == PreviousObjects::kRemove) {
    rules.withdrawn.insert(rules.withdrawn.end(), kept.begin(), kept.end());
  } else if (!kept.empty()) {
    plan.warnings.push_back(absl::StrCat(FormatCount(kept.size(), "rule"),
                                         " of pairs of before, which the scene says nothing of, ",
                                         kept.size() == 1 ? "stays" : "stay", ": see `cwm rules`"));
  }
  for (const pb::NamedPair& pair : rules.withdrawn) {
    pb::AllowCollision& allow = *plan.changes.emplace_back().mutable_allow();
    *allow.mutable_pair() = pair;
    allow.set_withdraw(true);
  }
  if (!rules.withdrawn.empty()) {
    plan.imported.push_back(FormatCount(rules.withdrawn.size(), "rule") + " of pairs withdrawn");
  }
  for (const pb::NamedPair& pair : rules.checked) {
    pb::AllowCollision& allow = *plan.changes.emplace_back().mutable_allow();
    *allow.mutable_pair() = pair;
    allow.set_check(true);
  }
  if (!rules.checked.empty()) {
    plan.imported.push_back(FormatCount(rules.checked.size(), "checked pair"));
  }
  if (rules.pairs.empty()) return;
  for (const pb::NamedPair& pair : rules.pairs) {
    *plan.changes.emplace_back().mutable_allow()->mutable_pair() = pair;
  }
  plan.imported.push_back(FormatCount(rules.pairs.size(), "allowed pair"));
}

// True if the file gives the object's pose in the world, independently of the robot.
bool HasWorldPose(const SceneAttachedObject& attached) {
  return !attached.pose_is_in_link || attached.object.shapes.empty();
}

void PlanAttached(const SceneAttachedObject& attached, const pb::Robot& robot, SceneImport& plan) {
  pb::AttachObject& attach = *plan.changes.emplace_back().mutable_attach();
  attach.set_name(ObjectName(attached.object.id));
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
                                         FormatNames(unknown), ": left out, ", robot.name(),
                                         " has no such links"));
  }
  // An object put in the link's frame moves to the link; otherwise it stays where it was put.
  if (HasWorldPose(attached)) return;
  const auto put = std::find_if(plan.changes.begin(), plan.changes.end(), [&](const auto& c) {
    return c.has_put() && c.put().object().name() == attach.name();
  });
  *attach.mutable_x_link_object() = put->put().object().x_world_object();
}

void PlanAttached(const SceneFile& scene, const pb::Robot& robot, SceneImport& plan) {
  std::size_t count = 0;
  for (const SceneAttachedObject& attached : scene.robot_state.attached) {
    if (HasLink(robot, attached.link)) {
      PlanAttached(attached, robot, plan);
      ++count;
      continue;
    }
    plan.warnings.push_back(absl::StrCat(
        formats::Printable(attached.object.id),
        HasWorldPose(attached) ? ": stands free, " : ": left out with its pose in that link, ",
        robot.name(), " has no link ", formats::Printable(attached.link), " to hold it"));
  }
  if (count > 0) plan.imported.push_back(FormatCount(count, "attached object"));
}

}  // namespace

bool ImportOptions::Includes(ScenePart part) const {
  return std::find(excluded.begin(), excluded.end(), part) == excluded.end();
}

bool NeedsRobot(const SceneFile& scene, const ImportOptions& options) {
  return (options.Includes(ScenePart::kState) && !scene.robot_state.empty()) ||
         (options.Includes(ScenePart::kAttached) && !scene.robot_state.attached.empty()) ||
         (options.Includes(ScenePart::kAllowed) &&
          (!scene.allowed_collisions.names.empty() || !scene.allowed_collisions.defaults.empty()));
}

absl::StatusOr<SceneImport> ConvertScene(const client::Connection& connection,
                                         const SceneFile& scene, const ImportOptions& options) {
  if (scene.is_diff && options.previous == PreviousObjects::kRemove) {
    return absl::InvalidArgumentError(
        "is_diff is true: the scene says only what differs from that of before, which must stay");
  }
  SceneImport plan;
  plan.warnings = scene.warnings;
  const pb::Robot* robot = NeedsRobot(scene, options) ? options.robot : nullptr;
  if (robot == nullptr && NeedsRobot(scene, options)) {
    plan.warnings.push_back(
        "the world has no robot: its state, what it holds and what its links may touch are left "
        "out; `cwm robot load` it first");
  } else if (robot != nullptr && !scene.robot_model_name.empty() &&
             robot->name() != scene.robot_model_name) {
    plan.warnings.push_back(absl::StrCat("the scene is of ",
                                         formats::Printable(scene.robot_model_name), ", taken for ",
                                         robot->name()));
  }
  const bool attaches = robot != nullptr && options.Includes(ScenePart::kAttached);
  std::vector<const SceneObject*> objects;
  for (const SceneObject& object : scene.objects) objects.push_back(&object);
  for (const SceneAttachedObject& attached : scene.robot_state.attached) {
    if (!attaches || attached.object.shapes.empty()) continue;
    if (HasWorldPose(attached) || HasLink(*robot, attached.link)) {
      objects.push_back(&attached.object);
    }
  }
  absl::Status status;
  if (robot != nullptr && options.Includes(ScenePart::kState))
    status = PlanState(scene, *robot, plan);
  if (status.ok()) PlanRemovals(scene, options, objects, plan);
  if (status.ok()) status = PlanObjects(connection, options, objects, plan);
  if (!status.ok()) return status;
  if (options.Includes(ScenePart::kAllowed)) PlanRules(scene, options, plan);
  if (attaches) PlanAttached(scene, *robot, plan);
  return plan;
}

}  // namespace cwm::scene
