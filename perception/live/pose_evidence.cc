#include "perception/live/pose_evidence.h"

#include <algorithm>
#include <cmath>

#include "perception/cloud/tolerances.h"
#include "perception/track/ray_classification.h"

namespace cwm::perception {
namespace {

// chosen: as in the test of removal: shares of the visible surface that rays pass through if the
// body is elsewhere, and if it is there.
constexpr double kPassedIfElsewhere = 0.9;
constexpr double kPassedIfThere = 0.25;

}  // namespace

NearbySurfaces::NearbySurfaces(const FrameEvidence& frame, std::span<const NeighbourBody> others,
                               BodyId own, const Vector3& center_W, double reach_m)
    : p_WC_(frame.X_WC.translation()) {
  const double range_m = (center_W - p_WC_).norm();
  within_m_ =
      kGate_sigma * std::hypot(frame.noise.AxialSigma_m(range_m), frame.noise.WarpSigma_m());
  const double reach_m2 = reach_m * reach_m;
  for (const RobotLinks& robot : frame.robots) {
    for (std::size_t i = 0; i < robot.links.size(); ++i) {
      const LinkSurface& surface = robot.surface->links()[i];
      if (surface.empty()) continue;
      const LinkAtStamp& link = robot.links[i];
      const Pose X_LW = link.X_WL.inverse();
      if (surface.bounds_L().squaredExteriorDistance(X_LW * center_W) > reach_m2) continue;
      const double speed_m_s = (link.V_WL.linear_W_m_s +
                                link.V_WL.angular_W_rad_s.cross(center_W - link.X_WL.translation()))
                                   .norm();
      const double within_m = within_m_ + speed_m_s * RobotMargins().clock_s;
      links_.push_back({&surface, X_LW, static_cast<float>(within_m)});
    }
  }
  for (const NeighbourBody& other : others) {
    if (other.id == own) continue;
    const Vector3 center_B = other.placed.X_LB.inverse() * (center_W - p_WC_);
    const Aabb& bounds_B = other.placed.surface->bounds_O();
    if (bounds_B.squaredExteriorDistance(center_B) <= reach_m2) bodies_.push_back(&other.placed);
  }
}

bool NearbySurfaces::Explain(const Vector3& p_W) const {
  for (const Link& link : links_) {
    const Eigen::Vector3f p_L = (link.X_LW * p_W).cast<float>();
    if (link.surface->MayBeWithin(p_L, 0, link.within_m) &&
        link.surface->IsWithin(p_L, link.within_m)) {
      return true;
    }
  }
  return std::ranges::any_of(
      bodies_, [&](const PlacedSurface* body) { return body->Explains(p_W - p_WC_, within_m_); });
}

bool PoseEvidence::IsHidden() const {
  return visible() <= kMinVisibleShare * (visible() + hidden + on_other);
}

PoseEvidence EvidenceAt(const FrameEvidence& frame, const BodySurface& body, const Pose& X_WB,
                        int expected_px, const NearbySurfaces& nearby) {
  static const double through = std::log(kPassedIfThere / kPassedIfElsewhere);
  static const double hit = std::log((1 - kPassedIfThere) / (1 - kPassedIfElsewhere));
  const Pose X_CB = frame.X_WC.inverse() * X_WB;
  const double sigma_m = FitGate_m(frame, X_WB) / kGate_sigma;
  PoseEvidence evidence;
  int facing = 0;
  double odds = 0;
  for (const SurfaceSample& sample : body.samples()) {
    const auto seen = SeenAt(frame, X_CB, sample);
    if (!seen) continue;
    ++facing;
    if (!seen->measured_m) continue;
    const double depth_m = *seen->measured_m;
    const Vector3& p_C = seen->p_C;
    const double error = (depth_m - p_C.z()) / sigma_m;
    if (error > kGate_sigma) {
      ++evidence.through;
      odds += through;
      continue;
    }
    if (error < -kGate_sigma) {
      ++evidence.hidden;
      continue;
    }
    if (nearby.Explain(frame.X_WC * Vector3(p_C * (depth_m / p_C.z())))) {
      ++evidence.on_other;
      continue;
    }
    ++evidence.hit;
    odds += std::max(through, hit - 0.5 * error * error);
  }
  // Samples that are closer than noise is correlated share their information.
  const double pixels_each = facing == 0 ? 0 : static_cast<double>(expected_px) / facing;
  evidence.log_odds = std::min(1.0, pixels_each / kPointsPerIndependentSample) * odds;
  return evidence;
}

}  // namespace cwm::perception
