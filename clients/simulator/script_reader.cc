#include <algorithm>
#include <filesystem>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/format_error.h"
#include "clients/simulator/scene_file.h"
#include "clients/simulator/script_yaml.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/scenes.h"

namespace cwm::simulator {
namespace {

using perception::SequenceScript;
using perception::SimulatedView;

// chosen: a script is text written by people.
constexpr std::int64_t kMaxScriptBytes = std::int64_t{16} << 20;
constexpr int kMaxSeed = 2'147'483'647;
constexpr int kTableObjects = 8;  // as cwm-simulator has by default

absl::StatusOr<std::uint64_t> ReadSeedOr(const YamlNode& node, std::uint64_t otherwise) {
  if (!node.present()) return otherwise;
  const auto seed = node.ReadInteger(0, kMaxSeed);
  if (!seed.ok()) return seed.status();
  return static_cast<std::uint64_t>(*seed);
}

absl::StatusOr<SimulatedView> ReadRandomScene(const YamlNode& node) {
  if (absl::Status status = node.CheckKeys({"random", "seed"}); !status.ok()) return status;
  std::vector<std::string> names;
  for (const perception::NamedFamily& family : perception::kSceneFamilies) {
    names.emplace_back(family.name);
  }
  const auto index = ReadNameOf(node["random"], "family", names);
  if (!index.ok()) return index.status();
  const auto seed = ReadSeedOr(node["seed"], 1);
  if (!seed.ok()) return seed.status();
  return perception::RandomScene(perception::kSceneFamilies[*index].family, *seed);
}

absl::StatusOr<SimulatedView> ReadSceneOf(const YamlNode& node) {
  if (node["random"].present()) return ReadRandomScene(node);
  if (node.is_map()) {
    if (absl::Status status = node.CheckKeys({"random", "seed", "file"}); !status.ok()) {
      return status;
    }
    const auto name = node["file"].ReadText();
    if (!name.ok()) return name.status();
    if (node["seed"].present()) return node["seed"].Error("must stand beside random");
    return ReadScene((std::filesystem::path(node.file()).parent_path() / *name).string());
  }
  const auto text = node.ReadText();
  if (!text.ok()) return text.status();
  if (*text == "kitchen") {
    return SimulatedView{.scene = perception::KitchenCounter(),
                         .camera = perception::KitchenCamera()};
  }
  if (*text == "table") {
    return SimulatedView{.scene = perception::RandomTable(1, kTableObjects),
                         .camera = perception::KitchenCamera()};
  }
  return node.Error("must be kitchen, table, {random: FAMILY, seed: N} or {file: a scene file}");
}

absl::StatusOr<ScriptFile> ReadRoot(const YamlNode& root) {
  absl::Status status = root.CheckKeys(
      {"scene", "duration_s", "start_stamp_s", "seed", "sensors", "robots", "hands", "events"});
  if (!status.ok()) return status;
  ScriptFile file;
  SequenceScript& script = file.script;
  auto view = ReadSceneOf(root["scene"]);
  if (!view.ok()) return view.status();
  script.scene = std::move(view->scene);
  const auto duration = ReadPositive(root["duration_s"]);
  if (!duration.ok()) return duration.status();
  if (*duration > kMaxDuration_s) {
    return root["duration_s"].Error(absl::StrCat("must be at most ", kMaxDuration_s));
  }
  script.duration_s = *duration;
  const auto start = ReadSecondsOr(root["start_stamp_s"], script.start_stamp_s);
  if (!start.ok()) return start.status();
  script.start_stamp_s = *start;
  const auto seed = ReadSeedOr(root["seed"], script.seed);
  if (!seed.ok()) return seed.status();
  script.seed = *seed;
  // Sensors and objects may be on links and in hands, which are read before.
  if (status = ReadRobots(root["robots"], file); !status.ok()) return status;
  if (status = ReadHands(root["hands"], script); !status.ok()) return status;
  if (status = ReadSensors(root["sensors"], view->camera, script); !status.ok()) return status;
  if (status = ReadEvents(root["events"], script); !status.ok()) return status;
  return file;
}

template <class Named>
std::vector<std::string> NamesOf(const std::vector<Named>& things) {
  std::vector<std::string> names;
  for (const Named& thing : things) names.push_back(thing.name);
  return names;
}

}  // namespace

absl::StatusOr<double> ReadPositive(const YamlNode& node) {
  auto number = node.ReadNumber();
  if (number.ok() && *number <= 0) return node.Error("must be positive");
  return number;
}

absl::StatusOr<double> ReadNumberOr(const YamlNode& node, double otherwise) {
  return node.present() ? node.ReadNumber() : otherwise;
}

absl::StatusOr<double> ReadSecondsOr(const YamlNode& node, double otherwise) {
  auto number = ReadNumberOr(node, otherwise);
  if (number.ok() && *number < 0) return node.Error("must not be negative");
  return number;
}

absl::StatusOr<double> ReadRateOr(const YamlNode& node, double otherwise) {
  auto rate = node.present() ? ReadPositive(node) : otherwise;
  if (rate.ok() && *rate > kMaxRate_hz) {
    return node.Error(absl::StrCat("must be at most ", kMaxRate_hz));
  }
  return rate;
}

absl::StatusOr<double> ReadTime(const YamlNode& node, double duration_s) {
  auto time = node.ReadNumber();
  if (time.ok() && (*time < 0 || *time > duration_s)) {
    return node.Error(absl::StrCat("must be from 0 to duration_s, ", duration_s));
  }
  return time;
}

absl::StatusOr<std::vector<double>> ReadTimes(const YamlNode& list, double duration_s) {
  if (list.size() == 0) return list.Error("must be a list with at least one time_s");
  std::vector<double> times_s;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto time = ReadTime(list[i]["time_s"], duration_s);
    if (!time.ok()) return time.status();
    if (!times_s.empty() && *time <= times_s.back()) {
      return list[i]["time_s"].Error("must be later than the one before");
    }
    times_s.push_back(*time);
  }
  return times_s;
}

absl::StatusOr<std::size_t> ReadNameOf(const YamlNode& node, const std::string& kind,
                                       const std::vector<std::string>& names) {
  const auto name = node.ReadText();
  if (!name.ok()) return name.status();
  const auto found = std::find(names.begin(), names.end(), *name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  return node.Error(absl::StrCat("is no ", kind, "; there ", names.size() == 1 ? "is " : "are ",
                                 names.empty() ? "none" : absl::StrJoin(names, ", ")));
}

absl::StatusOr<std::string> ReadNewName(const YamlNode& node,
                                        const std::vector<std::string>& taken) {
  auto name = node.ReadText();
  if (!name.ok()) return name.status();
  const bool good = std::all_of(name->begin(), name->end(), [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '.';
  });
  if (!good || name->front() == '.') {
    return node.Error("must have letters, digits, '_', '-' and '.', and not begin with '.'");
  }
  if (std::count(taken.begin(), taken.end(), *name) > 0) {
    return node.Error("must not appear twice");
  }
  return name;
}

std::vector<std::string> RobotNames(const SequenceScript& script) { return NamesOf(script.robots); }
std::vector<std::string> HandNames(const SequenceScript& script) { return NamesOf(script.hands); }

absl::StatusOr<perception::LinkRef> ReadLinkRef(const YamlNode& node,
                                                const SequenceScript& script) {
  const auto robot = ReadNameOf(node["robot"], "robot of the script", RobotNames(script));
  if (!robot.ok()) return robot.status();
  const auto link = ReadNameOf(node["link"], absl::StrCat("link of ", script.robots[*robot].name),
                               NamesOf(script.robots[*robot].links));
  if (!link.ok()) return link.status();
  return perception::LinkRef{.robot = *robot, .link = *link};
}

absl::StatusOr<ScriptFile> ReadScript(const std::string& path) {
  const auto bytes = formats::ReadFileBytes(path, kMaxScriptBytes);
  if (!bytes.ok()) return bytes.status();
  try {  // yaml-cpp reports errors by exceptions, which are handled here
    return ReadRoot(YamlNode(YAML::Load(*bytes), path));
  } catch (const YAML::Exception& error) {
    return formats::FileError(absl::StrCat(path, ":", error.mark.line + 1),
                              {.field = "YAML", .value = "", .rule = error.msg});
  }
}

}  // namespace cwm::simulator
