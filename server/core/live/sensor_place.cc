#include "server/core/live/sensor_place.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

absl::StatusOr<SensorPlace> PlaceOnRobot(const SensorMount& mount,
                                         std::span<const RobotAtFrame> robots) {
  const auto carrier = std::ranges::find_if(
      robots, [&](const RobotAtFrame& at) { return at.robot->name == mount.robot; });
  const std::optional<int> link =
      carrier == robots.end() ? std::nullopt : carrier->robot->model().FindLink(mount.link);
  if (!link.has_value()) {
    return MakeError(absl::StatusCode::kFailedPrecondition,
                     absl::StrCat("the link ", mount.robot, "/", mount.link,
                                  " that carries the sensor is no longer there"),
                     {.reason = "ROBOT_STATE_MISSING"});
  }
  if (carrier->state.source == perception::StateSource::kMissing) {
    return MakeError(absl::StatusCode::kFailedPrecondition,
                     absl::StrCat(MissingStateText(*carrier), ": nothing tells where the link ",
                                  mount.robot, "/", mount.link, " was, which carries the sensor"),
                     {.reason = carrier->state.reason});
  }
  const perception::LinkAtStamp& at = carrier->links[static_cast<std::size_t>(*link)];
  SensorPlace place{.X_WC = at.X_WL * mount.X_LC, .V_WC = at.V_WL};
  place.V_WC.linear_W_m_s +=
      at.V_WL.angular_W_rad_s.cross(place.X_WC.translation() - at.X_WL.translation());
  return place;
}

}  // namespace

bool IsUnplaced(const SensorCalibration& calibration, bool frame_has_pose,
                const std::optional<SensorPose>& kept) {
  return !frame_has_pose && !calibration.mount.has_value() && !calibration.X_WC.has_value() &&
         !kept.has_value();
}

absl::StatusOr<SensorPlace> PlaceAt(const SensorCalibration& calibration, const LiveFrame& frame,
                                    std::span<const RobotAtFrame> robots,
                                    const std::optional<PlaceAtStamp>& before,
                                    const std::optional<SensorPose>& kept) {
  if (frame.X_WC.has_value()) {
    SensorPlace place{.X_WC = *frame.X_WC};
    if (before.has_value() && before->X_WC.matrix() != frame.X_WC->matrix()) {
      const std::chrono::duration<double> since = frame.stamp - before->stamp;
      place.V_WC = perception::VelocityBetween(before->X_WC, place.X_WC, since.count());
    }
    return place;
  }
  if (calibration.mount.has_value()) return PlaceOnRobot(*calibration.mount, robots);
  if (calibration.X_WC.has_value()) return SensorPlace{.X_WC = *calibration.X_WC};
  if (kept.has_value()) return SensorPlace{.X_WC = kept->X_WC};
  return InvalidField("frame.x_world_sensor",
                      "is absent, must be set: neither the calibration nor an earlier scan tells "
                      "the sensor's pose");
}

absl::Status CheckMount(const SensorMount& mount, const collision::WorldSnapshot& snapshot) {
  const collision::WorldRobotPtr robot = snapshot.FindRobot(mount.robot);
  if (robot == nullptr) {
    return MakeError(absl::StatusCode::kNotFound,
                     absl::StrCat("calibration.mount.robot: there is no robot \"", mount.robot,
                                  "\" in this world"),
                     {.reason = "ROBOT_UNKNOWN", .metadata = {{"robot", mount.robot}}});
  }
  if (robot->model().FindLink(mount.link).has_value()) return absl::OkStatus();
  return MakeError(
      absl::StatusCode::kFailedPrecondition,
      absl::StrCat("calibration.mount.link: the robot \"", mount.robot, "\" has no link \"",
                   mount.link, "\""),
      {.reason = "LINK_UNKNOWN", .metadata = {{"robot", mount.robot}, {"link", mount.link}}});
}

}  // namespace cwm::server
