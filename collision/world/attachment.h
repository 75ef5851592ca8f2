// Checks and completes a request to attach an object.
#pragma once

#include "absl/status/statusor.h"
#include "collision/world/world_snapshot.h"

namespace cwm::collision {

// The attachment of the object to the robot, both as they are now. Without a pose in the request,
// an object that stays on its link keeps its pose in the link exactly. Refuses (FieldRuleOf:
// "name", "link", "x_link_object", "touch_links[2]") links that the robot does not have, poses that
// are not placeable, and unbounded objects.
absl::StatusOr<Attachment> AttachmentOf(const AttachObject& attach, const WorldRobot& robot,
                                        const WorldObject& object);

// True if both are nullptr or both are equal, with bitwise equal poses.
bool SameAttachment(const Attachment* a, const Attachment* b);

}  // namespace cwm::collision
