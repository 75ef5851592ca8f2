#include "clients/grasp/plan_report.h"

#include <nlohmann/json.hpp>

namespace cwm::grasp {
namespace {

using nlohmann::ordered_json;

ordered_json JsonOf(const Eigen::Vector3d& vector) { return {vector.x(), vector.y(), vector.z()}; }

ordered_json JsonOf(const Eigen::Isometry3d& X) {
  const Eigen::Quaterniond q(X.linear());
  const Eigen::Vector3d p = X.translation();
  return {{"tx_m", p.x()}, {"ty_m", p.y()}, {"tz_m", p.z()}, {"qx", q.x()},
          {"qy", q.y()},   {"qz", q.z()},   {"qw", q.w()}};
}

ordered_json JsonOf(const Factors& factors) {
  return {{"antipodal", factors.antipodal}, {"centred", factors.centred},
          {"observed", factors.observed},   {"clearance", factors.clearance},
          {"width", factors.width},         {"upright", factors.upright},
          {"still", factors.still}};
}

ordered_json JsonOf(const Grasp& grasp, const Eigen::Isometry3d& X_OW, double approach_m) {
  const Eigen::Isometry3d& X_WG = grasp.candidate.X_FG;
  ordered_json contacts = ordered_json::array();
  for (const Contact& contact : grasp.assessment.contacts) {
    contacts.push_back({{"point", JsonOf(contact.point_W)},
                        {"normal", JsonOf(contact.normal_W)},
                        {"angle_rad", contact.angle_rad},
                        {"part", contact.part}});
  }
  return {{"way", grasp.candidate.strategy},
          {"score", grasp.score},
          {"factors", JsonOf(grasp.factors)},
          {"x_world_grasp", JsonOf(X_WG)},
          {"x_world_pregrasp", JsonOf(X_WG * Eigen::Translation3d(0, 0, -approach_m))},
          {"x_object_grasp", JsonOf(X_OW * X_WG)},
          {"width_m", grasp.assessment.width_m},
          {"width_sigma_m", grasp.candidate.sigma_m},
          {"off_centre_m", grasp.assessment.off_centre_m},
          {"clearance_m", grasp.assessment.clearance_m},
          {"contacts", contacts}};
}

ordered_json JsonOf(const Gripper& gripper) {
  ordered_json boxes = ordered_json::array();
  for (const GripperBox& box : OpenBoxes(gripper)) {
    boxes.push_back({{"centre", JsonOf(box.centre_G)}, {"size_m", JsonOf(box.size_m)}});
  }
  return {{"opening_m", gripper.opening_m},
          {"finger_length_m", gripper.finger_length_m},
          {"finger_width_m", gripper.finger_width_m},
          {"finger_thickness_m", gripper.finger_thickness_m},
          {"pad_length_m", gripper.pad_length_m},
          {"palm_size_m", JsonOf(gripper.palm_size_m)},
          {"boxes", boxes}};
}

}  // namespace

std::string PlanJson(const Plan& plan, const PlanRequest& request) {
  ordered_json objects = ordered_json::array();
  for (const ObjectPlan& of_object : plan.objects) {
    const Eigen::Isometry3d X_OW = of_object.object.X_WO.inverse();
    ordered_json grasps = ordered_json::array();
    for (const Grasp& grasp : of_object.grasps) {
      grasps.push_back(JsonOf(grasp, X_OW, request.approach_m));
    }
    objects.push_back({{"name", of_object.object.name},
                       {"tried_count", of_object.tried_count},
                       {"free_count", of_object.free_count},
                       {"blocked_by", of_object.blocked_by},
                       {"why", of_object.failure_reason},
                       {"grasps", grasps}});
  }
  const ordered_json document = {{"world", plan.world},
                                 {"world_uid", plan.world_uid},
                                 {"revision", plan.revision},
                                 {"gripper", JsonOf(request.gripper)},
                                 {"friction", request.friction},
                                 {"approach_m", request.approach_m},
                                 {"clearance_m", request.clearance_m},
                                 {"objects", objects}};
  return document.dump(1) + "\n";
}

}  // namespace cwm::grasp
