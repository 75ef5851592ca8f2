#include "perception/live/static_balance.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "collision/geometry/polygon.h"
#include "perception/cloud/sensor_noise.h"

namespace cwm::perception {
namespace {

constexpr double kColumn_m = 0.01;  // chosen: a few points of a thing at 1 m
// chosen: rays pass below over at least so many steps, so that a rough foot is not taken for air.
constexpr int kMinFree_steps = 3;
// chosen: the mean of what is seen may be so far from the centre of mass, as a share of the size of
// the footprint: one side of a thing is hidden.
constexpr double kMeanError = 0.25;

class View {
 public:
  explicit View(const FrameEvidence& frame)
      : frame_(frame), R_CW_(frame.X_WC.linear().transpose()) {}

  // True if a ray passes through the point.
  bool SeesThrough(const Vector3& p_L) const {
    const Vector3 p_C = R_CW_ * p_L;
    const DepthCamera& camera = frame_.camera;
    if (p_C.z() < camera.least_range_m) return false;
    const Pinhole& pinhole = camera.pinhole;
    const auto u = std::lround(pinhole.focal_u_px * p_C.x() / p_C.z() + pinhole.center_u_px);
    const auto v = std::lround(pinhole.focal_v_px * p_C.y() / p_C.z() + pinhole.center_v_px);
    if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) return false;
    const double sigma_m = frame_.noise.AxialSigma_m(p_C.z());
    return frame_.image->at(static_cast<int>(u), static_cast<int>(v)) >
           p_C.z() + ExplainedWithin_m(sigma_m);
  }

 private:
  const FrameEvidence& frame_;
  const Matrix3 R_CW_;
};

// True if rays pass between the foot of a column and the support.
bool IsAboveAir(const Vector3& foot_L, double support_z_m, const View& view) {
  int free = 0;
  for (Vector3 p_L = foot_L; p_L.z() > support_z_m + kColumn_m && free < kMinFree_steps;) {
    p_L.z() -= kColumn_m;
    free = view.SeesThrough(p_L) ? free + 1 : 0;
  }
  return free >= kMinFree_steps;
}

}  // namespace

bool MayRest(std::span<const Eigen::Vector3f> points_L, const Pose& X_WS,
             const FrameEvidence& frame) {
  std::map<std::pair<long, long>, double> feet_m;  // the least z of each column
  for (const Eigen::Vector3f& p : points_L) {
    const std::pair column(std::lround(p.x() / kColumn_m), std::lround(p.y() / kColumn_m));
    const auto [foot, is_new] = feet_m.try_emplace(column, p.z());
    if (!is_new) foot->second = std::min(foot->second, double{p.z()});
  }
  const View view(frame);
  const Vector3 origin_L = X_WS.translation() - frame.X_WC.translation();
  const Vector3 normal_W = X_WS.linear().col(2);
  Vector2 mean = Vector2::Zero();
  std::vector<Vector2> contacts;
  for (const auto& [column, foot_m] : feet_m) {
    const Vector2 place =
        kColumn_m * Vector2(static_cast<double>(column.first), static_cast<double>(column.second));
    mean += place;
    const double support_z_m =
        origin_L.z() - normal_W.head<2>().dot(place - origin_L.head<2>()) / normal_W.z();
    if (!IsAboveAir({place.x(), place.y(), foot_m}, support_z_m, view)) contacts.push_back(place);
  }
  if (feet_m.empty()) return true;
  mean /= static_cast<double>(feet_m.size());
  const double size_m = kColumn_m * std::sqrt(static_cast<double>(feet_m.size()));
  if (contacts.empty()) return false;
  const Polygon hull = ConvexHull(std::move(contacts));
  if (hull.size() >= 3 && Contains(hull, mean)) return true;
  return (NearestOnBorder(hull, mean) - mean).norm() <= std::max(kColumn_m, kMeanError * size_m);
}

}  // namespace cwm::perception
