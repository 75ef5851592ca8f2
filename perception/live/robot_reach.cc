#include "perception/live/robot_reach.h"

#include <algorithm>
#include <vector>

namespace cwm::perception {
namespace {

// A link as part of the rigid body that a moving joint, or the root, carries.
struct LinkOfBody {
  bool is_base = true;           // no joint moves it
  Pose X_RL = Pose::Identity();  // in the frame of the body's first link
  double origin_m = 0;           // bound of the distance of that frame's origin from the centre
};

double FarthestCorner_m(const Aabb& bounds_L, const Pose& X_RL, const Vector3& center_R) {
  double farthest_m = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 p = X_RL * bounds_L.corner(static_cast<Aabb::CornerType>(corner));
    farthest_m = std::max(farthest_m, (p - center_R).norm());
  }
  return farthest_m;
}

}  // namespace

ReachSphere ReachOf(const RobotSurface& surface, std::span<const ReachJoint> joints) {
  ReachSphere reach{.center = Vector3::Zero(), .radius_m = 0};
  std::vector<LinkOfBody> links;
  bool has_center = false;
  for (const ReachJoint& joint : joints) {  // the centre first: base links refer to it
    const Pose X_RL = joint.parent < 0
                          ? joint.X_PL
                          : Pose(links[static_cast<std::size_t>(joint.parent)].X_RL * joint.X_PL);
    const bool is_base =
        !joint.moves && (joint.parent < 0 || links[static_cast<std::size_t>(joint.parent)].is_base);
    const bool is_first =
        joint.moves && !has_center &&
        (joint.parent < 0 || links[static_cast<std::size_t>(joint.parent)].is_base);
    if (is_first) reach.center = X_RL.translation();
    has_center = has_center || is_first;
    links.push_back({.is_base = is_base, .X_RL = X_RL});
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const ReachJoint& joint = joints[i];
    LinkOfBody& link = links[i];
    if (joint.parent >= 0) {
      const LinkOfBody& parent = links[static_cast<std::size_t>(joint.parent)];
      const Vector3 p_R = parent.X_RL * joint.X_PL.translation();
      if (joint.moves) {
        const double parent_m =
            parent.is_base ? (p_R - reach.center).norm() : parent.origin_m + p_R.norm();
        link = {.is_base = false, .X_RL = Pose::Identity(), .origin_m = parent_m + joint.travel_m};
      } else {
        link.X_RL = parent.X_RL * joint.X_PL;
        link.origin_m = parent.origin_m;
      }
    } else if (joint.moves) {
      link = {.is_base = false, .X_RL = Pose::Identity(), .origin_m = joint.travel_m};
    }
    const LinkSurface& geometry = surface.links()[i];
    if (geometry.empty()) continue;
    const Vector3 center_R = link.is_base ? reach.center : Vector3::Zero();
    reach.radius_m = std::max(
        reach.radius_m, link.origin_m + FarthestCorner_m(geometry.bounds_L(), link.X_RL, center_R));
  }
  return reach;
}

}  // namespace cwm::perception
