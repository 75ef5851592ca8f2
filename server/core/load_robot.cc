#include "server/core/load_robot.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "collision/query/self_collisions.h"
#include "collision/robot/kinematics.h"
#include "collision/robot/sphere_model.h"
#include "collision/robot/srdf.h"
#include "collision/robot/urdf.h"
#include "collision/xml/xml_element.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

using collision::ModelLink;
using collision::Quoted;
using collision::RobotLimits;

absl::Status Stopped() { return absl::CancelledError("the caller went away"); }

// Converts a reader's error about a file to the error of the request's field. The readers' messages
// begin with the kind of the file.
absl::Status InFile(const std::string& field, const absl::Status& status) {
  if (absl::IsCancelled(status)) return Stopped();
  std::string message(status.message());
  if (absl::IsResourceExhausted(status)) return RobotTooLarge(absl::StrCat(field, ": ", message));
  const std::string kind = field.substr(field.find('.') + 1) + ": ";
  if (message.starts_with(kind)) message.erase(0, kind.size());
  return InvalidField(field, std::move(message));
}

// Moves the files out: each is read once.
collision::MeshSource SourceOf(RobotFiles& files, const std::stop_token& stop) {
  return [&files, stop](std::string_view uri) -> absl::StatusOr<std::string> {
    if (stop.stop_requested()) return Stopped();
    const auto file = files.meshes.find(uri);
    if (file == files.meshes.end()) {
      return absl::NotFoundError("must be one of the files sent along");
    }
    return std::move(file->second);
  };
}

// Refuses settings of links and groups that the robot does not have.
absl::Status CheckSettings(const collision::RobotSettings& settings,
                           const collision::RobotModel& model) {
  const auto unknown = [&](const std::string& list, std::size_t i, const char* what,
                           const std::string& name) {
    return InvalidField(
        absl::StrCat("header.", list, "[", i, "].", what),
        absl::StrCat("is ", Quoted(name), ", must be a ", what, " of robot ", Quoted(model.name)));
  };
  const auto check = [&](const collision::LinkValues& values, const std::string& list) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::string& link = values[i].link;
      if (link != collision::kOtherLinks && !model.FindLink(link)) {
        return unknown(list, i, "link", link);
      }
    }
    return absl::OkStatus();
  };
  if (auto status = check(settings.padding_m, "link_padding"); !status.ok()) return status;
  if (auto status = check(settings.scale, "link_scale"); !status.ok()) return status;
  for (std::size_t i = 0; i < settings.tools.size(); ++i) {
    const collision::NamedTool& tool = settings.tools[i];
    if (!model.FindLink(tool.link)) return unknown("tools", i, "link", tool.link);
    if (tool.group.empty()) continue;
    const collision::JointGroup* const group = model.FindGroup(tool.group);
    if (group == nullptr) return unknown("tools", i, "group", tool.group);
    if (std::ranges::binary_search(group->moved_links, *model.FindLink(tool.link))) continue;
    return InvalidField(absl::StrCat("header.tools[", i, "].group"),
                        absl::StrCat("is ", Quoted(tool.group), ", must be a group that moves ",
                                     Quoted(tool.link)));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const collision::RobotModel>> ModelOf(RobotFiles& files,
                                                                     const RobotLimits& limits,
                                                                     const std::stop_token& stop) {
  auto robot =
      collision::ReadUrdf(files.urdf, SourceOf(files, stop), limits, stop, files.settings.scale);
  if (!robot.ok()) return InFile("header.urdf", robot.status());
  std::optional<collision::SemanticDescription> semantic;
  if (files.srdf.has_value()) {
    auto read = collision::ReadSrdf(*files.srdf, *robot, limits, stop);
    if (!read.ok()) return InFile("header.srdf", read.status());
    semantic = *std::move(read);
  }
  auto model = collision::MakeRobotModel(*std::move(robot), semantic ? &*semantic : nullptr);
  if (!model.ok()) return InFile("header.urdf", model.status());
  if (auto status = CheckSettings(files.settings, **model); !status.ok()) return status;
  auto with_settings = std::make_shared<collision::RobotModel>(**model);
  collision::SetRobotSettings(files.settings, *with_settings);
  return with_settings;
}

absl::StatusOr<std::optional<collision::SphereModel>> SpheresOf(RobotFiles& files,
                                                                const collision::RobotModel& model,
                                                                const RobotLimits& limits,
                                                                const std::stop_token& stop) {
  if (!files.spheres.has_value()) return std::nullopt;
  const auto spherized = collision::ReadUrdf(*files.spheres, SourceOf(files, stop), limits, stop,
                                             files.settings.scale);
  if (!spherized.ok()) return InFile("header.spheres", spherized.status());
  auto spheres = collision::SphereModelFromUrdf(*spherized, model);
  if (!spheres.ok()) return InFile("header.spheres", spheres.status());
  return *std::move(spheres);
}

bool HasOpenMesh(const ModelLink& link) {
  return std::any_of(link.collisions.begin(), link.collisions.end(), [](const auto& collision) {
    const Mesh* mesh = std::get_if<Mesh>(&collision.shape);
    return mesh != nullptr && !mesh->watertight;
  });
}

// "a hole of 9.0 mm" or "3 holes, the largest 9.0 mm" of the link's meshes; empty if none of them
// has closed holes.
std::string ClosedHoles(const ModelLink& link) {
  std::size_t count = 0;
  double largest_m = 0;
  for (const auto& collision : link.collisions) {
    if (!HasCaps(collision.shape)) continue;
    for (const MeshCap& cap : *std::get<Mesh>(collision.shape).caps) {
      ++count;
      largest_m = std::max(largest_m, cap.diameter_m);
    }
  }
  if (count == 0) return "";
  const std::string size = absl::StrFormat("%.1f mm", 1e3 * largest_m);
  return count == 1 ? absl::StrCat("a hole of ", size)
                    : absl::StrCat(count, " holes, the largest ", size);
}

// Adds the warning "KIND(s) NAMES WHAT" with at most five names; adds none if there are no names.
void AddWarning(const char* kind, const std::vector<std::string>& names, const std::string& what,
                std::vector<std::string>& warnings) {
  constexpr std::size_t kMaxNames = 5;
  if (names.empty()) return;
  const std::size_t shown = std::min(names.size(), kMaxNames);
  const std::string more =
      names.size() > shown ? absl::StrCat(" and ", names.size() - shown, " more") : "";
  warnings.push_back(absl::StrCat(
      kind, names.size() == 1 ? " " : "s ",
      absl::StrJoin(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "), more,
      " ", what));
}

// Named states that are out of limits, as "STATE of GROUP (VARIABLE is VALUE, must be from LOWER to
// UPPER)".
std::vector<std::string> StatesOutOfLimits(const collision::RobotModel& model) {
  const std::vector<double> inside = collision::DefaultVariables(model);
  std::vector<std::string> found;
  for (const collision::JointGroup& group : model.groups) {
    for (const collision::NamedState& named : group.states) {
      std::vector<double> state = inside;
      for (std::size_t k = 0; k < named.variables.size(); ++k) {
        state[static_cast<std::size_t>(named.variables[k])] = named.values[k];
      }
      const auto at = collision::OutOfLimits(model, state);
      if (!at) continue;
      const collision::Variable& variable = model.variables[static_cast<std::size_t>(*at)];
      const std::string rule = std::isfinite(variable.lower) || std::isfinite(variable.upper)
                                   ? absl::StrCat("from ", variable.lower, " to ", variable.upper)
                                   : "of a quaternion of length 1";
      found.push_back(absl::StrCat(named.name, " of ", group.name, " (", variable.name, " is ",
                                   state[static_cast<std::size_t>(*at)], ", must be ", rule, ")"));
    }
  }
  return found;
}

void AddSelfCollisions(const collision::RobotGeometry& robot, std::span<const double> state,
                       std::vector<std::string>& warnings) {
  const auto found = collision::FindSelfCollisions(robot, state);
  if (!found) return;
  const auto name_of = [&](const collision::LinkPair& pair) {
    const auto& links = robot.model->links;
    return absl::StrCat(links[static_cast<std::size_t>(pair.first)].name, " with ",
                        links[static_cast<std::size_t>(pair.second)].name);
  };
  std::vector<std::string> always, named;
  for (const collision::LinkPair& pair : found->always) always.push_back(name_of(pair));
  AddWarning("pair", always,
             "always in collision, in each of the sampled states: no state is free; add "
             "<disable_collisions> to the SRDF, or allow the links to collide",
             warnings);
  for (const collision::SelfCollisions::InState& each : found->states) {
    if (each.state.empty()) {
      warnings.push_back(absl::StrCat("the initial state is in self-collision, ",
                                      name_of(each.links), ": give another initial state"));
    } else {
      named.push_back(absl::StrCat(each.state, " of ", each.group, " (", name_of(each.links), ")"));
    }
  }
  AddWarning("named state", named,
             "in self-collision, with the other joints at their defaults: correct it, or disable "
             "the pair in the SRDF",
             warnings);
}

}  // namespace

absl::StatusOr<std::shared_ptr<const collision::RobotGeometry>> ReadRobot(
    RobotFiles files, const RobotLimits& limits, const std::stop_token& stop) {
  auto model = ModelOf(files, limits, stop);
  if (!model.ok()) return model.status();
  auto spheres = SpheresOf(files, **model, limits, stop);
  if (!spheres.ok()) return spheres.status();
  if (stop.stop_requested()) return Stopped();
  auto robot = collision::PrepareRobot(*std::move(model), *std::move(spheres), stop);
  if (robot == nullptr) return Stopped();
  if (files.files_hash.empty()) return robot;
  auto kept = std::make_shared<collision::RobotGeometry>(*robot);
  kept->files_hash = files.files_hash;
  return kept;
}

std::vector<std::string> WarningsOf(const collision::RobotGeometry& robot, bool has_srdf,
                                    std::span<const double> state) {
  std::vector<std::string> warnings;
  if (!has_srdf) {
    warnings.push_back(
        "no SRDF was given: there are no groups, and all pairs of links are checked but "
        "neighbours; load it with its SRDF");
  }
  std::vector<std::string> open, capped, bare;
  for (const ModelLink& link : robot.model->links) {
    if (HasOpenMesh(link)) open.push_back(link.name);
    if (const std::string holes = ClosedHoles(link); !holes.empty()) {
      capped.push_back(absl::StrCat(link.name, " (", holes, ")"));
    }
    // A frame fixed to its parent link needs no geometry of its own.
    const bool is_fixed = link.kind == collision::JointKind::kFixed;
    if (link.collisions.empty() && !is_fixed) bare.push_back(link.name);
  }
  const std::vector<std::string>& left_out = robot.model->left_out;
  warnings.insert(warnings.end(), left_out.begin(), left_out.end());
  AddWarning("joint", robot.model->narrowing,
             "with limits that narrow those of the joint it follows", warnings);
  AddWarning("joint", robot.model->contradicting,
             "with limits that contradict those of the joint it follows: not kept; correct them",
             warnings);
  AddWarning("named state", StatesOutOfLimits(*robot.model),
             "out of limits: the verdict about such a state is OUT_OF_LIMITS; correct it",
             warnings);
  std::vector<std::string> still;
  for (const collision::JointGroup& group : robot.model->groups) {
    if (group.variables.empty()) still.push_back(group.name);
  }
  AddWarning("group", still, "without a joint that moves: there is one state of it", warnings);
  AddSelfCollisions(robot, state, warnings);
  AddWarning("link", open, "with an open mesh: surfaces alone, without an inside; close the mesh",
             warnings);
  AddWarning("link", capped, "with holes in a mesh that were closed: answers near them are BOUNDED",
             warnings);
  AddWarning("link", bare,
             "without collision geometry: never in collision; add a <collision> if it has a body",
             warnings);
  return warnings;
}

absl::StatusOr<WriteOutcome> LoadRobot(World& world, const collision::PutRobot& put,
                                       const WriteOptions& options, const Limits& limits) {
  const auto make = [&](const SnapshotPtr& base) -> absl::StatusOr<std::vector<collision::Change>> {
    if (base->Find(put.name) != nullptr) {
      return InvalidField("header.name", absl::StrCat("is \"", put.name,
                                                      "\", must not be the name of an object of "
                                                      "the world"));
    }
    const auto count = static_cast<std::int64_t>(base->robots().size());
    if (count >= limits.max_robots && base->FindRobot(put.name) == nullptr) {
      return MakeError(absl::StatusCode::kResourceExhausted,
                       absl::StrCat("the world has ", count, " robots, must have at most ",
                                    limits.max_robots, " (max_robots)"),
                       {.reason = "TOO_MANY_ROBOTS"});
    }
    return std::vector<collision::Change>{{put, std::nullopt}};
  };
  return world.Update(make, options);
}

absl::StatusOr<WriteOutcome> RemoveRobot(World& world, const std::string& name,
                                         const WriteOptions& options) {
  const auto make = [&](const SnapshotPtr& base) -> absl::StatusOr<std::vector<collision::Change>> {
    if (base->FindRobot(name) == nullptr) return UnknownRobot(name);
    return std::vector<collision::Change>{{collision::RemoveRobot{name}, std::nullopt}};
  };
  return world.Update(make, options);
}

absl::Status UnknownRobot(std::string_view name) {
  return MakeError(absl::StatusCode::kNotFound,
                   absl::StrCat("name: there is no robot \"", std::string(name), "\""),
                   {.reason = "ROBOT_UNKNOWN", .metadata = {{"robot", std::string(name)}}});
}

absl::Status RobotTooLarge(std::string message) {
  return MakeError(absl::StatusCode::kResourceExhausted, std::move(message),
                   {.reason = "ROBOT_TOO_LARGE"});
}

}  // namespace cwm::server
