#include "clients/grasp/assess.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>

namespace cwm::grasp {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// Places on a pad, as shares of its half width and half length: the middle first, then outwards.
constexpr std::array<std::array<double, 2>, 15> kPadPoints = {{{0, 0},
                                                               {0, 0.4},
                                                               {0, -0.4},
                                                               {0.8, 0},
                                                               {-0.8, 0},
                                                               {0, 0.8},
                                                               {0, -0.8},
                                                               {0.8, 0.4},
                                                               {0.8, -0.4},
                                                               {-0.8, 0.4},
                                                               {-0.8, -0.4},
                                                               {0.8, 0.8},
                                                               {0.8, -0.8},
                                                               {-0.8, 0.8},
                                                               {-0.8, -0.8}}};
constexpr std::size_t kRaysPerAttempt = 2 * kPadPoints.size();

Body BodyOf(const std::vector<GripperBox>& boxes) {
  std::vector<api::Placed> parts;
  for (const GripperBox& box : boxes) {
    parts.push_back({.shape = Box{box.size_m.x(), box.size_m.y(), box.size_m.z()},
                     .X_BS = Isometry3d(Eigen::Translation3d(box.centre_G))});
  }
  return parts;
}

// The place of a pad that touches something first; of places within a micrometre, the first in the
// list. The ray of the middle must have hit.
std::size_t FirstHit(const RayResult& rays, std::size_t middle) {
  constexpr double kSame_m = 1e-6;
  std::size_t first = middle;
  for (std::size_t ray = middle + 1; ray < middle + kPadPoints.size(); ++ray) {
    if (!rays.hit[ray]) continue;
    const double sooner_m = rays.distance_m[static_cast<Eigen::Index>(first)] -
                            rays.distance_m[static_cast<Eigen::Index>(ray)];
    if (sooner_m > kSame_m) first = ray;
  }
  return first;
}

// Indices of the attempts that are still worth a query.
using Indices = std::vector<std::size_t>;

class Assessor {
 public:
  Assessor(const WorldView& world, const GraspQuery& query, const std::vector<Attempt>& attempts)
      : world_(world), query_(query), attempts_(attempts), answers_(attempts.size()) {}

  // Checks that the open gripper has room at the grasp: the cheapest query, which most attempts
  // fail.
  void CheckGraspPoses();
  void CheckApproaches();
  void CheckClosing();
  void CastContactRays();
  std::vector<Assessment> Take() { return std::move(answers_); }

 private:
  Indices Remaining() const {
    Indices remaining;
    for (std::size_t i = 0; i < answers_.size(); ++i) {
      if (answers_[i].failure == GraspFailure::kNone) remaining.push_back(i);
    }
    return remaining;
  }
  std::vector<Isometry3d> PosesOf(const Indices& indices) const {
    std::vector<Isometry3d> poses;
    for (const std::size_t i : indices) poses.push_back(attempts_[i].X_WG);
    return poses;
  }
  // Blocks the attempts that are not free.
  void RecordVerdicts(const CheckResult& checked, const Indices& indices);
  void ReadContacts(const RayResult& rays, std::size_t first_ray, std::size_t i);

  const WorldView& world_;
  const GraspQuery& query_;
  const std::vector<Attempt>& attempts_;
  std::vector<Assessment> answers_;
};

void Assessor::RecordVerdicts(const CheckResult& checked, const Indices& indices) {
  for (std::size_t k = 0; k < indices.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    if (checked.free(row)) continue;
    Assessment& answer = answers_[indices[k]];
    answer.failure = GraspFailure::kBlocked;
    if (checked.verdict[k] == Verdict::kCollision) answer.obstacle = checked.pair(row).object;
  }
}

void Assessor::CheckGraspPoses() {
  const Indices all = Remaining();
  RecordVerdicts(world_.Check(BodyOf(OpenBoxes(query_.gripper)), PosesOf(all),
                              {.margin_m = query_.clearance_m}),
                 all);
}

void Assessor::CheckApproaches() {
  const Indices remaining = Remaining();
  const std::vector<Isometry3d> ends = PosesOf(remaining);
  std::vector<Isometry3d> starts = ends;
  for (Isometry3d& X_WG : starts) X_WG = X_WG * Eigen::Translation3d(0, 0, -query_.approach_m);
  const MotionResult motions = world_.Motions(BodyOf(OpenBoxes(query_.gripper)), starts, ends,
                                              {.margin_m = query_.clearance_m});
  for (std::size_t k = 0; k < remaining.size(); ++k) {
    const auto motion = static_cast<Eigen::Index>(k);
    Assessment& answer = answers_[remaining[k]];
    if (motions.free(motion)) {
      answer.clearance_m = query_.clearance_m + motions.clearance_m[motion];
      continue;
    }
    answer.failure = GraspFailure::kBlocked;
    answer.obstacle = motions.pair(motion).object;
  }
}

void Assessor::CheckClosing() {
  std::map<std::string, Indices> by_target;
  for (const std::size_t i : Remaining()) {
    if (!attempts_[i].target.empty()) by_target[attempts_[i].target].push_back(i);
  }
  const Body closing = BodyOf({ClosingBox(query_.gripper)});
  for (const auto& [target, indices] : by_target) {
    RecordVerdicts(world_.Check(closing, PosesOf(indices), {.ignore = {target}}), indices);
  }
}

void Assessor::CastContactRays() {
  const Indices remaining = Remaining();
  const auto count = static_cast<Eigen::Index>(kRaysPerAttempt * remaining.size());
  Eigen::Matrix3Xd origins(3, count), directions(3, count);
  Eigen::Index ray = 0;
  for (const std::size_t i : remaining) {
    const Isometry3d& X_WG = attempts_[i].X_WG;
    for (const double side : {-1.0, 1.0}) {
      for (const auto& [y, z] : kPadPoints) {
        origins.col(ray) = X_WG * Vector3d(side * query_.gripper.opening_m / 2,
                                           y * query_.gripper.finger_width_m / 2,
                                           z * query_.gripper.pad_length_m / 2);
        directions.col(ray) = -side * X_WG.linear().col(0);
        ++ray;
      }
    }
  }
  const RayResult rays =
      world_.Rays(origins, directions, {.max_distance_m = query_.gripper.opening_m});
  for (std::size_t k = 0; k < remaining.size(); ++k) {
    ReadContacts(rays, k * kRaysPerAttempt, remaining[k]);
  }
}

void Assessor::ReadContacts(const RayResult& rays, std::size_t first_ray, std::size_t i) {
  Assessment& answer = answers_[i];
  const Vector3d closing_W = attempts_[i].X_WG.linear().col(0);
  std::array<double, 2> travel_m = {};  // the travel of each finger until its pad touches something
  for (std::size_t side = 0; side < 2; ++side) {
    const std::size_t middle = first_ray + side * kPadPoints.size();
    if (!rays.hit[middle]) {
      answer.failure = GraspFailure::kMissed;
      return;
    }
    const std::size_t first = FirstHit(rays, middle);
    const auto hit = static_cast<Eigen::Index>(first);
    const std::string touched = rays.object(hit);
    if (answer.held_object.empty()) answer.held_object = touched;
    const std::string& wanted =
        attempts_[i].target.empty() ? answer.held_object : attempts_[i].target;
    if (touched != wanted) {
      answer.failure = GraspFailure::kMissed;
      answer.obstacle = touched;
      return;
    }
    travel_m[side] = rays.distance_m[hit];
    const auto& [y, z] = kPadPoints[first - middle];
    const double direction = side == 0 ? 1 : -1;
    Contact& contact = answer.contacts[side];
    contact.point_W =
        attempts_[i].X_WG * Vector3d(direction * (travel_m[side] - query_.gripper.opening_m / 2),
                                     y * query_.gripper.finger_width_m / 2,
                                     z * query_.gripper.pad_length_m / 2);
    contact.normal_W = rays.normal.col(hit);
    contact.angle_rad =
        std::acos(std::clamp(-contact.normal_W.dot(direction * closing_W), -1.0, 1.0));
    contact.part = rays.object_part[hit];
    contact.trust = rays.trust[first];
  }
  answer.width_m = query_.gripper.opening_m - travel_m[0] - travel_m[1];
  answer.off_centre_m = std::abs(travel_m[0] - travel_m[1]) / 2;
  const double steepest = std::max(answer.contacts[0].angle_rad, answer.contacts[1].angle_rad);
  if (answer.width_m <= 0) {
    answer.failure = GraspFailure::kMissed;
  } else if (steepest > std::atan(query_.friction)) {
    answer.failure = GraspFailure::kSlipped;
  }
}

}  // namespace

std::vector<Assessment> Assess(const WorldView& world, const GraspQuery& query,
                               const std::vector<Attempt>& attempts) {
  Assessor assessor(world, query, attempts);
  assessor.CheckGraspPoses();
  assessor.CheckApproaches();
  assessor.CheckClosing();
  assessor.CastContactRays();
  return assessor.Take();
}

}  // namespace cwm::grasp
