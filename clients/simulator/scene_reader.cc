#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/format_error.h"
#include "clients/simulator/pose_yaml.h"
#include "clients/simulator/scene_file.h"
#include "clients/simulator/shape_yaml.h"

namespace cwm::simulator {
namespace {

using perception::Finish;
using perception::PieceRole;
using perception::PinholeCamera;
using perception::SimulatedObject;
using perception::SimulatedView;

// chosen: a scene is text written by people; meshes have files of their own.
constexpr std::int64_t kMaxSceneBytes = std::int64_t{64} << 20;

absl::StatusOr<PinholeCamera> ReadCamera(const YamlNode& node) {
  if (!node.present()) return node.Error("is missing");
  absl::Status status =
      node.CheckKeys({"width", "height", "focal_px", "center_px", "pose", "look_at"});
  if (!status.ok()) return status;
  PinholeCamera camera;
  if (status = ReadLens(node, camera); !status.ok()) return status;
  const auto X_WC = ReadViewpoint(node);
  if (!X_WC.ok()) return X_WC.status();
  camera.X_WC = *X_WC;
  return camera;
}

absl::StatusOr<PieceRole> ReadRole(const YamlNode& node) {
  if (!node.present()) return PieceRole::kBody;
  const auto text = node.ReadText();
  if (!text.ok()) return text.status();
  if (*text == "body") return PieceRole::kBody;
  if (*text == "handle") return PieceRole::kHandle;
  if (*text == "spout") return PieceRole::kSpout;
  return node.Error("must be body, handle or spout");
}

absl::Status ReadPart(const YamlNode& node, SimulatedObject& object) {
  absl::Status status = node.CheckKeys({"sphere", "box", "cylinder", "cone", "capsule", "plate",
                                        "half_space", "mesh", "pose", "role"});
  if (!status.ok()) return status;
  std::vector<std::string_view> kinds;
  for (const std::string_view key : kShapeKeys) {
    if (node.Has(key)) kinds.push_back(key);
  }
  if (kinds.size() != 1) return node.Error("must hold one shape, and only one");
  const auto shape = ReadShape(node, kinds.front());
  if (!shape.ok()) return shape.status();
  const auto X_OS = ReadPose(node["pose"]);
  if (!X_OS.ok()) return X_OS.status();
  const auto role = ReadRole(node["role"]);
  if (!role.ok()) return role.status();
  object.parts.push_back({.X_FS = *X_OS, .shape = *shape});
  object.part_roles.push_back(*role);
  return absl::OkStatus();
}

absl::StatusOr<bool> ReadFlagOr(const YamlNode& node, bool otherwise) {
  return node.present() ? node.ReadFlag() : otherwise;
}

class SceneReader {
 public:
  absl::StatusOr<SimulatedView> Read(const YamlNode& root) {
    if (absl::Status status = root.CheckKeys({"camera", "objects"}); !status.ok()) return status;
    const auto camera = ReadCamera(root["camera"]);
    if (!camera.ok()) return camera.status();
    view_.camera = *camera;
    const YamlNode objects = root["objects"];
    if (!objects.is_list()) {
      return objects.Error(objects.present() ? "must be a list" : "is missing");
    }
    for (std::size_t i = 0; i < objects.size(); ++i) {
      if (absl::Status status = ReadObject(objects[i]); !status.ok()) return status;
    }
    return std::move(view_);
  }

 private:
  absl::Status ReadObject(const YamlNode& node) {
    absl::Status status = node.CheckKeys({"name", "support", "shiny", "pose", "parts"});
    if (!status.ok()) return status;
    SimulatedObject object;
    const auto name = node["name"].ReadText();
    if (!name.ok()) return name.status();
    if (!names_.insert(*name).second) return node["name"].Error("must not appear twice");
    object.name = *name;
    const auto support = ReadFlagOr(node["support"], false);
    if (!support.ok()) return support.status();
    object.is_support = *support;
    const auto shiny = ReadFlagOr(node["shiny"], false);
    if (!shiny.ok()) return shiny.status();
    object.finish = *shiny ? Finish::kShiny : Finish::kMatt;
    const auto X_WO = ReadPose(node["pose"]);
    if (!X_WO.ok()) return X_WO.status();
    object.X_WO = *X_WO;
    if (status = ReadParts(node["parts"], object); !status.ok()) return status;
    view_.scene.objects.push_back(std::move(object));
    return absl::OkStatus();
  }

  absl::Status ReadParts(const YamlNode& node, SimulatedObject& object) {
    if (node.size() == 0) return node.Error("must be a list of at least one part");
    part_count_ += node.size();
    if (part_count_ > kMaxParts) {
      return node.Error(absl::StrCat("goes beyond the ", kMaxParts, " parts of a scene"));
    }
    for (std::size_t i = 0; i < node.size(); ++i) {
      if (absl::Status status = ReadPart(node[i], object); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  SimulatedView view_;
  std::set<std::string> names_;
  std::size_t part_count_ = 0;
};

}  // namespace

absl::StatusOr<SimulatedView> ReadScene(const std::string& path) {
  const auto bytes = formats::ReadFileBytes(path, kMaxSceneBytes);
  if (!bytes.ok()) return bytes.status();
  try {  // yaml-cpp reports errors by exceptions, which are handled here
    return SceneReader().Read(YamlNode(YAML::Load(*bytes), path));
  } catch (const YAML::Exception& error) {
    return formats::FileError(absl::StrCat(path, ":", error.mark.line + 1),
                              {.field = "YAML", .value = "", .rule = error.msg});
  }
}

}  // namespace cwm::simulator
