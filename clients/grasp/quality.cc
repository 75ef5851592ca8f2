#include "clients/grasp/quality.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace cwm::grasp {
namespace {

using Eigen::Vector3d;

constexpr double kMinFactor =
    0.05;  // the smallest value of a factor: bad grasps can still be ranked
constexpr double kUnseenPart = 0.2;  // completed without measurements, by symmetry or support

double ClampFactor(double value) { return std::clamp(value, kMinFactor, 1.0); }

double ObservedShare(const Object& object, int index) {
  // Behind the parts are meshes of measured points.
  if (index < 0 || static_cast<std::size_t>(index) >= object.parts.size()) return 1;
  const Part& part = object.parts[static_cast<std::size_t>(index)];
  if (part.role == PartRole::kCompleted) return kUnseenPart;
  return part.fit ? part.fit->observed_fraction : 1.0;
}

// The share that was observed of what the pads touch: of the worse contact, since one that is a
// guess suffices to miss. The far side of a face counts as unseen if the target may extend beyond
// it, and so does one side of an open surface of a scan that both pads touch.
double ObservedShare(const Object& object, const std::array<Contact, 2>& contacts) {
  double least = 1;
  bool is_open = object.owner == Owner::kPerception;
  for (const Contact& contact : contacts) {
    const bool is_guess = contact.trust == Trust::kBounded;
    least = std::min(least, is_guess ? kUnseenPart : ObservedShare(object, contact.part));
    is_open = is_open && contact.trust == Trust::kSurfaceOnly;
  }
  return is_open ? std::min(least, kUnseenPart) : least;
}

Vector3d CentreOf(const Object& object) {
  if (!object.bounds) return object.X_WO.translation();
  return object.X_WO * object.bounds->X_OB.translation();
}

double DistanceToLine_m(const Vector3d& point, const Vector3d& origin, const Vector3d& direction) {
  return (point - origin).cross(direction).norm();
}

}  // namespace

Factors FactorsOf(const Candidate& candidate, const Assessment& assessment, const Object& object,
                  const GraspQuery& query) {
  constexpr double kLever_m = 0.05;       // chosen: halves the factor; fingers are 2 cm wide
  constexpr double kEnoughRoom_m = 0.01;  // derived: three times the error of a depth camera at 1 m
  constexpr double kPush_m = 0.01;        // chosen: halves the factor; small objects topple beyond
  const Eigen::Isometry3d& X_WG = candidate.X_FG;
  const auto& [a, b] = assessment.contacts;
  const double cone_rad = std::atan(query.friction);
  const double lever_m =
      DistanceToLine_m(CentreOf(object), X_WG.translation(), X_WG.linear().col(0));
  const double gap_m = (query.gripper.opening_m - assessment.width_m) / 2;
  return {
      .antipodal = ClampFactor(1 - std::max(a.angle_rad, b.angle_rad) / std::max(cone_rad, 1e-9)),
      .centred = ClampFactor(1 / (1 + lever_m / kLever_m)),
      .observed = ClampFactor(ObservedShare(object, assessment.contacts)),
      .clearance = ClampFactor(assessment.clearance_m / kEnoughRoom_m),
      .width = ClampFactor(gap_m / (3 * candidate.sigma_m + kEnoughRoom_m / 2)),
      .upright = ClampFactor((1 - X_WG.linear()(2, 2)) / 2),
      .still = ClampFactor(1 / (1 + assessment.off_centre_m / kPush_m)),
  };
}

double ScoreOf(const Factors& factors) {
  // Holding and reaching the object, and that it is there, count twice as much as preferences.
  const double log_score = 2 * std::log(factors.antipodal) + 1 * std::log(factors.centred) +
                           2 * std::log(factors.observed) + 2 * std::log(factors.clearance) +
                           2 * std::log(factors.width) + 1 * std::log(factors.upright) +
                           1 * std::log(factors.still);
  constexpr double kWeights = 11;
  return std::exp(log_score / kWeights);
}

}  // namespace cwm::grasp
