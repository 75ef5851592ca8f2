#include "perception/simulation/several_views.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "perception/simulation/random_draws.h"
#include "perception/simulation/range_image.h"

namespace cwm::perception {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kArc_rad = 80 * kDegree;  // a walk around half a table, before the walls
constexpr std::uint64_t kRegistrationStream = 1003;

// Uniform on the sphere (Archimedes).
Vector3 DrawDirection(RandomDraws& draws) {
  const double z = draws.Uniform(-1, 1);
  const double angle_rad = draws.Uniform(0, 2 * std::numbers::pi);
  const double level = std::sqrt(1 - z * z);
  return {level * std::cos(angle_rad), level * std::sin(angle_rad), z};
}

// The place on the camera's axis at the median of the visible depths; at one metre if nothing is
// visible.
Vector3 LookedAt_W(const SimulatedScene& scene, const PinholeCamera& camera) {
  std::vector<double> depths_m;
  for (const Sighting& pixel : Render(scene, camera).pixels) {
    if (pixel.seen()) depths_m.push_back(pixel.depth_m);
  }
  double depth_m = 1;
  if (!depths_m.empty()) {
    const auto middle = depths_m.begin() + static_cast<std::ptrdiff_t>(depths_m.size() / 2);
    std::nth_element(depths_m.begin(), middle, depths_m.end());
    depth_m = *middle;
  }
  return camera.X_WC * (depth_m * Vector3::UnitZ());
}

Pose TurnAbout(const Vector3& point, const Quaternion& turn) {
  return Eigen::Translation3d(point) * turn * Eigen::Translation3d(-point);
}

// The angles of the views after the given one: from one end of the arc to the other, not in its
// middle.
double Azimuth_rad(int view, int view_count) {
  if (view == 0) return 0;
  const int others = view_count - 1;
  const double share = others == 1 ? 1 : static_cast<double>(view - 1) / (others - 1);
  const double azimuth_rad = kArc_rad * (share - 0.5);
  constexpr double kMin_rad = 10 * kDegree;
  return std::abs(azimuth_rad) < kMin_rad ? kMin_rad : azimuth_rad;
}

Pose RegistrationError(const Vector3& about_W, RandomDraws& draws) {
  const double angle_rad = draws.Uniform(0.2, 0.5) * kDegree;
  const Vector3 axis = DrawDirection(draws);
  const double shift_m = draws.Uniform(0.002, 0.005);
  const Vector3 towards = DrawDirection(draws);
  return Eigen::Translation3d(shift_m * towards) *
         TurnAbout(about_W, Quaternion(Eigen::AngleAxisd(angle_rad, axis)));
}

// Appends the points of a view, transformed to the first camera's frame.
void Append(const SimulatedCloud& view, const Pose& X_CC, SimulatedCloud& all) {
  for (std::size_t i = 0; i < view.cloud.points.size(); ++i) {
    if (!view.cloud.points[i].allFinite()) continue;
    all.cloud.points.push_back((X_CC * view.cloud.points[i].cast<double>()).cast<float>());
    all.object.push_back(view.object[i]);
    all.part.push_back(view.part[i]);
  }
}

}  // namespace

RegisteredViews ScanFromSeveralViews(const SimulatedScene& scene, const PinholeCamera& camera,
                                     int view_count, const ScanOptions& options) {
  assert(view_count > 0);
  const Vector3 looked_at_W = LookedAt_W(scene, camera);
  RandomDraws draws(options.seed, kRegistrationStream);
  RegisteredViews views;
  for (int view = 0; view < view_count; ++view) {
    const Quaternion turn(Eigen::AngleAxisd(Azimuth_rad(view, view_count), Vector3::UnitZ()));
    PinholeCamera turned = camera;
    turned.X_WC = TurnAbout(looked_at_W, turn) * camera.X_WC;
    const Pose error_W = view == 0 ? Pose::Identity() : RegistrationError(looked_at_W, draws);
    ScanOptions own = options;
    own.seed = options.seed + static_cast<std::uint64_t>(view);
    views.X_WC.push_back(turned.X_WC);
    views.X_CC.push_back(camera.X_WC.inverse() * error_W * turned.X_WC);
    Append(Scan(scene, turned, own), views.X_CC.back(), views.cloud);
  }
  views.cloud.cloud.width = static_cast<int>(views.cloud.cloud.points.size());
  return views;
}

}  // namespace cwm::perception
