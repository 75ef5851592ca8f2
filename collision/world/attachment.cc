#include "collision/world/attachment.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "collision/world/apply_fault.h"
#include "collision/world/model_equality.h"
#include "collision/world/robot_transaction.h"

namespace cwm::collision {
namespace {

bool IsBounded(const PreparedModel& geometry) {
  return std::all_of(geometry.parts.begin(), geometry.parts.end(),
                     [](const PreparedPart& part) { return part.bounds_O.sizes().allFinite(); });
}

absl::Status NoLink(const std::string& field, const std::string& link, const WorldRobot& robot) {
  return InvalidFieldError(field,
                           absl::StrCat("'", link, "' must be a link of robot '", robot.name, "'"));
}

Pose PoseInLink(const AttachObject& attach, const Pose& X_WL, const WorldObject& object) {
  if (attach.X_LO.has_value()) return *attach.X_LO;
  const Attachment* current = object.attachment.get();
  const bool stays =
      current != nullptr && current->robot == attach.robot && current->link == attach.link;
  return stays ? current->X_LO : X_WL.inverse() * object.X_WO;
}

}  // namespace

absl::StatusOr<Attachment> AttachmentOf(const AttachObject& attach, const WorldRobot& robot,
                                        const WorldObject& object) {
  const std::optional<int> link = robot.model().FindLink(attach.link);
  if (!link.has_value()) return NoLink("link", attach.link, robot);
  if (attach.X_LO.has_value() && !IsPlaceable(*attach.X_LO))
    return InvalidPoseError("x_link_object");
  for (std::size_t i = 0; i < attach.touch_links.size(); ++i) {
    const std::string& touched = attach.touch_links[i];
    if (robot.model().FindLink(touched).has_value()) continue;
    return NoLink(absl::StrCat("touch_links[", i, "]"), touched, robot);
  }
  if (!IsBounded(*object.geometry)) {
    return InvalidFieldError(
        "name",
        absl::StrCat("'", object.name, "' has a half-space, must be bounded to be attached"));
  }
  Attachment attachment{
      .robot = attach.robot,
      .link = attach.link,
      .X_LO = PoseInLink(attach, robot.X_WL[static_cast<std::size_t>(*link)], object),
      .touch_links = attach.touch_links};
  std::vector<std::string>& touch = attachment.touch_links;
  std::sort(touch.begin(), touch.end());
  touch.erase(std::unique(touch.begin(), touch.end()), touch.end());
  return attachment;
}

bool SameAttachment(const Attachment* a, const Attachment* b) {
  if (a == b || a == nullptr || b == nullptr) return a == b;
  return a->robot == b->robot && a->link == b->link && SamePose(a->X_LO, b->X_LO) &&
         a->touch_links == b->touch_links;
}

}  // namespace cwm::collision
