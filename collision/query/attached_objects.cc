#include "collision/query/attached_objects.h"

#include <algorithm>
#include <utility>

namespace cwm::collision {
namespace {

std::vector<AttachedObject> AttachedTo(const WorldRobot& robot, const WorldSnapshot& world,
                                       std::span<const std::string> ignore) {
  std::vector<AttachedObject> attached;
  for (const WorldObjectPtr& object : world.attached()) {
    if (object->attachment->robot != robot.name) continue;
    if (std::find(ignore.begin(), ignore.end(), object->name) != ignore.end()) continue;
    const std::optional<int> link = robot.model().FindLink(object->attachment->link);
    if (!link.has_value()) continue;  // the world detaches objects whose link disappears
    attached.push_back({.object = object, .link = *link, .X_FO = object->attachment->X_LO});
  }
  return attached;
}

// True if parts in the frame are tested against the attached object.
bool IsTested(const QueryBody& body, const AttachedObject& attached, int frame) {
  if (const AttachedObject* other = body.AttachedIn(frame)) return other->link != attached.link;
  if (frame == attached.link) return false;
  const std::vector<std::string>& touch = attached.object->attachment->touch_links;
  const std::string& link = body.robot->links[static_cast<std::size_t>(frame)].name;
  return !std::binary_search(touch.begin(), touch.end(), link);
}

}  // namespace

std::size_t CountAttachedParts(const WorldSnapshot& world, const WorldRobot& robot,
                               std::span<const std::string> ignore) {
  std::size_t count = 0;
  for (const AttachedObject& attached : AttachedTo(robot, world, ignore)) {
    count += attached.object->geometry->parts.size();
  }
  return count;
}

QueryBody WithAttachedObjects(QueryBody body, const WorldSnapshot& world, const WorldRobot& robot,
                              RobotScope scope, std::span<const std::string> ignore) {
  body.attached = AttachedTo(robot, world, ignore);
  if (body.attached.empty()) return body;
  auto geometry = std::make_shared<PreparedModel>(*body.geometry);
  for (std::size_t k = 0; k < body.attached.size(); ++k) {
    const AttachedObject& attached = body.attached[k];
    const PreparedModel& added = *attached.object->geometry;
    const std::size_t before = geometry->parts.size();
    for (std::size_t part = 0; part < added.parts.size(); ++part) {
      const auto mine = static_cast<std::int32_t>(before + part);
      for (std::size_t other = 0; other < before && scope != RobotScope::kWorld; ++other) {
        const auto theirs = static_cast<std::int32_t>(other);
        if (!body.IsSelfOnly(theirs) && IsTested(body, attached, body.FrameOf(theirs)))
          body.self_pairs.push_back({mine, theirs});
      }
    }
    geometry->parts.insert(geometry->parts.end(), added.parts.begin(), added.parts.end());
    geometry->max_sigma_m = std::max(geometry->max_sigma_m, added.max_sigma_m);
    geometry->has_caps = geometry->has_caps || added.has_caps;
    body.hidden_m = std::max(body.hidden_m, added.max_hidden_m);
    body.frame_of_part.resize(geometry->parts.size(), body.frame_count + static_cast<int>(k));
  }
  body.geometry = std::move(geometry);
  return body;
}

}  // namespace cwm::collision
