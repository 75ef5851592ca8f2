#include "clients/simulator/pose_yaml.h"

#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "clients/simulator/scene_file.h"
#include "perception/simulation/look_at.h"

namespace cwm::simulator {
namespace {

// chosen: quaternions written with two or three decimals are off by up to half a percent; more is
// an error.
constexpr double kQuaternionTolerance = 0.01;

double Radians(double degrees) { return degrees * std::numbers::pi / 180; }

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

}  // namespace

absl::StatusOr<Vector3> ReadVector(const YamlNode& node) {
  const auto values = node.ReadNumbers(3);
  if (!values.ok()) return values.status();
  return Vector3((*values)[0], (*values)[1], (*values)[2]);
}

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

absl::StatusOr<Pose> ReadViewpoint(const YamlNode& node) {
  const YamlNode pose = node["pose"];
  const YamlNode look_at = node["look_at"];
  if (pose.present() == look_at.present()) {
    return node.Error("must hold either pose or look_at");
  }
  return pose.present() ? ReadPose(pose) : ReadLookAt(look_at);
}

absl::Status ReadLens(const YamlNode& node, perception::PinholeCamera& camera) {
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

}  // namespace cwm::simulator
