#include "server/store/decode_values.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/world/apply_fault.h"
#include "server/store/decode_fault.h"

namespace cwm::server {
namespace {

absl::Status CheckStoredName(const std::string& name) {
  if (collision::IsValidName(name)) return absl::OkStatus();
  return Broken("name", "must be 1 to 128 letters, digits and _-./");
}

// One of the enumerators from 0 to `last`.
template <class Enum>
absl::StatusOr<Enum> DecodeEnum(std::int32_t value, Enum last, std::string_view field) {
  const auto max = static_cast<std::int32_t>(last);
  if (value >= 0 && value <= max) return static_cast<Enum>(value);
  return Broken(field, absl::StrCat("is ", value, ", must be from 0 to ", max));
}

absl::Status CheckRevisions(std::initializer_list<std::int64_t> revisions) {
  const bool are_valid = std::ranges::all_of(revisions, [](std::int64_t r) { return r > 0; });
  return are_valid ? absl::OkStatus() : Broken("revisions", "must be positive");
}

absl::StatusOr<collision::Attachment> DecodeAttachment(const store::v1::Attachment& attachment) {
  collision::Attachment decoded;
  decoded.robot = attachment.robot();
  decoded.link = attachment.link();
  absl::StatusOr<Pose> X_LO = DecodePose(attachment.x_lo());
  if (!X_LO.ok()) return Within("x_lo", X_LO.status());
  decoded.X_LO = *X_LO;
  decoded.touch_links.assign(attachment.touch_links().begin(), attachment.touch_links().end());
  const std::vector<std::string>& links = decoded.touch_links;
  if (std::ranges::adjacent_find(links, std::greater_equal<>()) != links.end()) {
    return Broken("touch_links", "must be in order, each once");
  }
  return decoded;
}

}  // namespace

Clock::time_point SteadyTimeOf(std::int64_t when_ns, const ClockPair& now) {
  // Decades are enough, and no clock overflows.
  constexpr std::chrono::nanoseconds kLongest = std::chrono::hours(24 * 365 * 30);
  const std::int64_t now_ns =
      std::chrono::duration_cast<std::chrono::nanoseconds>(now.wall.time_since_epoch()).count();
  if (when_ns >= now_ns) return now.steady;
  if (when_ns < now_ns - kLongest.count()) return now.steady - kLongest;
  return now.steady - std::chrono::nanoseconds(now_ns - when_ns);
}

collision::WallTime WallTimeOf(std::int64_t when_ns) {
  return collision::WallTime(std::chrono::nanoseconds(when_ns));
}

absl::StatusOr<collision::WorldObject> DecodeObject(const store::v1::Object& object) {
  if (absl::Status status = CheckStoredName(object.name()); !status.ok()) return status;
  collision::WorldObject decoded;
  decoded.name = object.name();
  decoded.margin_m = object.margin_m();
  if (!std::isfinite(decoded.margin_m) || decoded.margin_m < 0) {
    return Broken("margin_m", "must be finite and not negative");
  }
  absl::StatusOr<Pose> X_WO = DecodePose(object.x_wo());
  if (!X_WO.ok()) return Within("x_wo", X_WO.status());
  decoded.X_WO = *X_WO;
  if (object.has_attachment()) {
    absl::StatusOr<collision::Attachment> attachment = DecodeAttachment(object.attachment());
    if (!attachment.ok()) return Within("attachment", attachment.status());
    decoded.attachment = std::make_shared<const collision::Attachment>(*std::move(attachment));
  }
  decoded.supported_by = object.supported_by();
  decoded.create_revision.value = object.create_revision();
  decoded.geometry_revision.value = object.geometry_revision();
  decoded.pose_revision.value = object.pose_revision();
  const absl::Status revisions = CheckRevisions(
      {object.create_revision(), object.geometry_revision(), object.pose_revision()});
  if (!revisions.ok()) return revisions;
  const auto kind = DecodeEnum(object.kind(), collision::ObjectKind::kMover, "kind");
  if (!kind.ok()) return kind.status();
  const auto owner = DecodeEnum(object.owner(), collision::Owner::kUser, "owner");
  if (!owner.ok()) return owner.status();
  const auto state = DecodeEnum(object.state(), collision::ObjectState::kLost, "state");
  if (!state.ok()) return state.status();
  decoded.kind = *kind;
  decoded.owner = *owner;
  decoded.state = *state;
  return decoded;
}

absl::StatusOr<collision::WorldRobot> DecodeRobot(const store::v1::Robot& robot) {
  if (absl::Status status = CheckStoredName(robot.name()); !status.ok()) return status;
  collision::WorldRobot decoded;
  decoded.name = robot.name();
  absl::StatusOr<Pose> X_WB = DecodePose(robot.x_wb());
  if (!X_WB.ok()) return Within("x_wb", X_WB.status());
  decoded.X_WB = *X_WB;
  decoded.state.assign(robot.state().begin(), robot.state().end());
  decoded.create_revision.value = robot.create_revision();
  decoded.state_revision.value = robot.state_revision();
  const absl::Status revisions = CheckRevisions({robot.create_revision(), robot.state_revision()});
  if (!revisions.ok()) return revisions;
  return decoded;
}

absl::StatusOr<collision::PairRule> DecodeRule(const store::v1::PairRule& rule,
                                               const ClockPair& now) {
  collision::PairRule decoded;
  decoded.pair = {.a = {.name = rule.a().name(), .link = rule.a().link()},
                  .b = {.name = rule.b().name(), .link = rule.b().link()}};
  if (absl::Status status = collision::CheckPair(decoded.pair); !status.ok()) {
    return Broken("pair", std::string(status.message()));
  }
  if (decoded.pair.b < decoded.pair.a) return Broken("pair", "must be in order");
  decoded.allowed = rule.allowed();
  decoded.check = rule.check();
  if (decoded.allowed && decoded.check) return Broken("check", "must not be allowed as well");
  if (rule.has_expires_ns()) {
    const collision::WallTime end = WallTimeOf(rule.expires_ns());
    // Decades are enough, and no clock overflows.
    constexpr std::chrono::nanoseconds kLongest = std::chrono::hours(24 * 365 * 30);
    const bool is_past = end <= now.wall;
    const bool is_far = !is_past && end - kLongest > now.wall;
    const auto left = is_past ? std::chrono::nanoseconds(0) : is_far ? kLongest : end - now.wall;
    decoded.expires = collision::Expiry{.due = now.steady + left, .wall_time = end};
  }
  if (rule.has_margin_m()) {
    decoded.margin_m = rule.margin_m();
    if (!std::isfinite(rule.margin_m()) || rule.margin_m() < 0) {
      return Broken("margin_m", "must be finite and not negative");
    }
  }
  return decoded;
}

absl::StatusOr<NamedSensorPose> DecodeSensorPose(const store::v1::SensorPose& pose) {
  absl::StatusOr<Pose> X_WC = DecodePose(pose.x_wc());
  if (!X_WC.ok()) return Within("x_wc", X_WC.status());
  return NamedSensorPose{.sensor = pose.sensor(), .pose = {.X_WC = *X_WC, .given = pose.given()}};
}

Sighting DecodeSighting(const store::v1::Sighting& sighting) {
  Sighting decoded{.name = sighting.name(), .is_new = sighting.is_new()};
  if (sighting.has_reachable()) decoded.reachable = sighting.reachable();
  return decoded;
}

WrittenRequest DecodeRequest(const store::v1::Request& request) {
  return {.id = request.id(), .digest = request.digest(), .is_ingest = request.is_ingest()};
}

}  // namespace cwm::server
