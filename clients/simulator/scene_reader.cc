#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/format_error.h"
#include "clients/simulator/scene_file.h"
#include "clients/simulator/shape_yaml.h"
#include "perception/simulation/look_at.h"

namespace cwm::simulator {
namespace {

using perception::Finish;
using perception::PieceRole;
using perception::PinholeCamera;
using perception::SimulatedObject;
using perception::SimulatedView;

// chosen: a scene is text written by people; meshes have files of their own.
constexpr std::int64_t kMaxSceneBytes = std::int64_t{64} << 20;

// chosen: quaternions written with two or three decimals are off by up to half a percent; more is
// an error.
constexpr double kQuaternionTolerance = 0.01;

double Radians(double degrees) { return degrees * std::numbers::pi / 180; }

absl::StatusOr<Vector3> ReadVector(const YamlNode& node) {
  const auto values = node.ReadNumbers(3);
  if (!values.ok()) return values.status();
  return Vector3((*values)[0], (*values)[1], (*values)[2]);
}

absl::StatusOr<Quaternion> ReadQuaternion(const YamlNode& node) {
  const auto xyzw = node.ReadNumbers(4);
  if (!xyzw.ok()) return xyzw.status();
  const Quaternion q((*xyzw)[3], (*xyzw)[0], (*xyzw)[1], (*xyzw)[2]);
  if (!(std::abs(q.norm() - 1) <= kQuaternionTolerance)) {
    return node.Error(absl::StrCat("has length ", q.norm(), ", must be within 1 % of 1"));
  }
  return q.normalized();
}

// Roll about x, pitch about y, yaw about z, each about the axes of the outer frame, as in URDF.
absl::StatusOr<Quaternion> ReadRollPitchYaw(const YamlNode& node) {
  const auto degrees = node.ReadNumbers(3);
  if (!degrees.ok()) return degrees.status();
  return Eigen::AngleAxisd(Radians((*degrees)[2]), Vector3::UnitZ()) *
         Eigen::AngleAxisd(Radians((*degrees)[1]), Vector3::UnitY()) *
         Quaternion(Eigen::AngleAxisd(Radians((*degrees)[0]), Vector3::UnitX()));
}

// The identity if there is none; position and rotation are both optional.
absl::StatusOr<Pose> ReadPose(const YamlNode& node) {
  if (!node.present()) return Pose::Identity();
  absl::Status status = node.CheckKeys({"position_m", "quaternion_xyzw", "rpy_deg"});
  if (!status.ok()) return status;
  Vector3 position_m = Vector3::Zero();
  if (const YamlNode given = node["position_m"]; given.present()) {
    const auto read = ReadVector(given);
    if (!read.ok()) return read.status();
    position_m = *read;
  }
  const YamlNode quaternion = node["quaternion_xyzw"];
  const YamlNode angles = node["rpy_deg"];
  if (quaternion.present() && angles.present()) {
    return angles.Error("must not stand beside quaternion_xyzw");
  }
  absl::StatusOr<Quaternion> rotation = Quaternion::Identity();
  if (quaternion.present()) rotation = ReadQuaternion(quaternion);
  if (angles.present()) rotation = ReadRollPitchYaw(angles);
  if (!rotation.ok()) return rotation.status();
  return MakePose(position_m, *rotation);
}

absl::StatusOr<Pose> ReadLookAt(const YamlNode& node) {
  absl::Status status = node.CheckKeys({"from_m", "at_m"});
  if (!status.ok()) return status;
  const auto from = ReadVector(node["from_m"]);
  if (!from.ok()) return from.status();
  const auto at = ReadVector(node["at_m"]);
  if (!at.ok()) return at.status();
  constexpr double kApart_m = 1e-6;  // at a smaller distance the direction is rounding
  if (!((*at - *from).norm() > kApart_m)) return node["at_m"].Error("must differ from from_m");
  return perception::LookAt(*from, *at);
}

absl::Status ReadLens(const YamlNode& node, PinholeCamera& camera) {
  const auto width = node["width"].ReadInteger(1, kMaxPixelsPerSide);
  if (!width.ok()) return width.status();
  const auto height = node["height"].ReadInteger(1, kMaxPixelsPerSide);
  if (!height.ok()) return height.status();
  const auto focal = node["focal_px"].ReadNumber();
  if (!focal.ok()) return focal.status();
  if (*focal <= 0) return node["focal_px"].Error("must be positive");
  camera = {.width = *width,
            .height = *height,
            .focal_px = *focal,
            .center_x_px = 0.5 * (*width - 1),
            .center_y_px = 0.5 * (*height - 1)};
  if (!node["center_px"].present()) return absl::OkStatus();
  const auto center = node["center_px"].ReadNumbers(2);
  if (!center.ok()) return center.status();
  camera.center_x_px = (*center)[0];
  camera.center_y_px = (*center)[1];
  return absl::OkStatus();
}

absl::StatusOr<PinholeCamera> ReadCamera(const YamlNode& node) {
  if (!node.present()) return node.Error("is missing");
  absl::Status status =
      node.CheckKeys({"width", "height", "focal_px", "center_px", "pose", "look_at"});
  if (!status.ok()) return status;
  PinholeCamera camera;
  if (status = ReadLens(node, camera); !status.ok()) return status;
  const YamlNode pose = node["pose"];
  const YamlNode look_at = node["look_at"];
  if (pose.present() == look_at.present()) {
    return node.Error("must hold either pose or look_at");
  }
  const auto X_WC = pose.present() ? ReadPose(pose) : ReadLookAt(look_at);
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
