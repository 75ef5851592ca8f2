// What a change asks to attach, as the world may hold it.
#pragma once

#include "absl/status/statusor.h"
#include "collision/world/world_snapshot.h"

namespace cwm::collision {

// Of the object, as it is, to the robot, as it is. One that stays on its link and says no pose
// keeps the one that it has there, to the last bit. Refuses (FieldRuleOf: "name", "link",
// "x_link_object", "touch_links[2]") links that the robot does not have, a pose that no world may
// hold, and objects without end.
absl::StatusOr<Attachment> AttachmentOf(const AttachObject& attach, const WorldRobot& robot,
                                        const WorldObject& object);

// Either may be nullptr. Bitwise equal poses.
bool SameAttachment(const Attachment* a, const Attachment* b);

}  // namespace cwm::collision
