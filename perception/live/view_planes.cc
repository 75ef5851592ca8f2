#include "perception/live/view_planes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// chosen: the reaches of the window of a local plane, the first one within which the surface is
// plane, and the least pixels on each side. Normals are as exact as windows are wide.
constexpr std::array<double, 2> kWindows_m = {0.03, 0.012};
constexpr int kMinWindow_px = 2;
constexpr int kWindowSteps = 5;  // on each side, at most
// chosen: planes that are seen at more than 75 degrees tell little but of edges.
constexpr double kMinFacing_cos = 0.26;

}  // namespace

std::optional<ViewPlane> ViewPlanes::Fit(int u, int v) const {
  if (depth_m(u, v) == 0) return std::nullopt;
  for (const double window_m : kWindows_m) {
    if (auto plane = FitWithin(u, v, window_m)) return plane;
  }
  return std::nullopt;
}

std::optional<ViewPlane> ViewPlanes::FitWithin(int u, int v, double window_m) const {
  const float z = depth_m(u, v);
  const DepthCamera& camera = view_.camera;
  const int reach =
      std::max(kMinWindow_px, static_cast<int>(window_m * camera.pinhole.focal_u_px / z));
  if (u < reach || v < reach || u + reach >= camera.width || v + reach >= camera.height) {
    return std::nullopt;
  }
  const int stride = (reach + kWindowSteps - 1) / kWindowSteps;
  const double sigma_m = view_.noise.AxialSigma_m(z);
  // Planes are steeper than that only beyond the least angle of incidence.
  const double most_m = 2 * window_m / kMinFacing_cos + kGate_sigma * sigma_m;
  Vector3 sum = Vector3::Zero();
  Matrix3 squares = Matrix3::Zero();
  int count = 0;
  int all = 0;
  const Vector3 middle = rays_.Point(u, v, z).cast<double>();
  for (int dv = -reach; dv <= reach; dv += stride) {
    for (int du = -reach; du <= reach; du += stride, ++all) {
      const float near_m = depth_m(u + du, v + dv);
      if (near_m == 0) continue;
      if (std::abs(near_m - z) > most_m) return std::nullopt;  // an edge
      const Vector3 p = rays_.Point(u + du, v + dv, near_m).cast<double>() - middle;
      sum += p;
      squares += p * p.transpose();
      ++count;
    }
  }
  if (count < kMainShare * all) return std::nullopt;
  const Vector3 mean = sum / count;
  Eigen::SelfAdjointEigenSolver<Matrix3> axes;
  axes.computeDirect(squares / count - mean * mean.transpose());
  const double thickness_m2 = std::max(0.0, axes.eigenvalues()[0]);
  // An edge within the window, or a surface that is no plane at this scale.
  if (thickness_m2 > sigma_m * sigma_m) return std::nullopt;
  Vector3 normal = axes.eigenvectors().col(0);
  const Vector3 at = middle + mean;
  const double facing = normal.dot(at) / at.norm();
  if (std::abs(facing) < kMinFacing_cos) return std::nullopt;
  if (facing > 0) normal = -normal;
  // The slope of a line through points with these errors, of which so many are independent.
  const double independent = std::max(1.0, count * stride * stride / kPointsPerIndependentSample);
  const double warp_slope = warp_m_ / kWarpCorrelation_m;
  return ViewPlane{.p_W = view_.X_WC.translation() + at,
                   .normal_W = normal,
                   .depth_m = static_cast<double>(z),
                   .normal_variance = thickness_m2 / (independent * axes.eigenvalues()[1]) +
                                      warp_slope * warp_slope};
}

}  // namespace cwm::perception
