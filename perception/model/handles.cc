#include "perception/model/handles.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/geometry/signed_distance.h"
#include "perception/model/connectivity.h"
#include "perception/model/solid.h"

namespace cwm::perception {
namespace {

// The paper states no numbers ("fairly large, elongated"). Assumed: the outer sizes of the handles
// of cups, mugs, pans and jugs for the table, with some room; not measured on a data set.
constexpr std::size_t kLeastPoints = 60;  // as of a shape: ModelerOptions::min_inliers
constexpr double kLeastLength_m = 0.02;
constexpr double kMostLength_m = 0.25;
constexpr double kMostWidth_m = 0.06;       // of the second extent
constexpr double kMostThickness_m = 0.035;  // of the third
constexpr double kLeastElongation = 1.4;    // first extent to second
constexpr double kRootGap_m = 0.015;        // from the surface to its nearest point
constexpr double kLeastReach_m = 0.015;     // of its farthest point: more than a rough wall
constexpr double kLeastCell_m = 0.006;      // 4 sigma of a Kinect at 0.8 m: noise parts no handle
constexpr double kCellSpacings = 3;         // as in Connectivity
constexpr int kPointsPerPiece = 2048;       // of some 0.2 us

struct Host {
  std::size_t solid = 0;
  double nearest_m = std::numeric_limits<double>::infinity();
  double farthest_m = 0;
};

Host NearestHost(const OrientedPoints& points, const std::vector<std::uint32_t>& cluster,
                 const std::vector<ShapePart>& solids, const Work& work) {
  PollEvery poll(work, kPointsPerPiece);
  Host best;
  for (std::size_t k = 0; k < solids.size(); ++k) {
    const Pose X_SL = solids[k].X_OS.inverse();
    Host host{k};
    for (std::uint32_t i : cluster) {
      poll();
      const double distance_m =
          SignedDistance_m(solids[k].shape, X_SL * points.points[i].cast<double>());
      host.nearest_m = std::min(host.nearest_m, std::abs(distance_m));
      host.farthest_m = std::max(host.farthest_m, distance_m);
    }
    if (host.nearest_m < best.nearest_m) best = host;
  }
  return best;
}

// Axes of largest, middle and least extent, and the box along them.
Placed<Box> PrincipalBox(const OrientedPoints& points, const std::vector<std::uint32_t>& cluster) {
  Vector3 mean = Vector3::Zero();
  for (std::uint32_t i : cluster) mean += points.points[i].cast<double>();
  mean /= static_cast<double>(cluster.size());
  Matrix3 covariance = Matrix3::Zero();
  for (std::uint32_t i : cluster) {
    const Vector3 x = points.points[i].cast<double>() - mean;
    covariance += x * x.transpose();
  }
  const Matrix3 vectors = Eigen::SelfAdjointEigenSolver<Matrix3>(covariance).eigenvectors();
  Placed<Box> box;
  Matrix3 R;
  R.col(0) = CanonicalAxis(vectors.col(2), Vector3::UnitZ());
  R.col(2) = CanonicalAxis(vectors.col(0), Vector3::UnitZ());
  R.col(1) = R.col(2).cross(R.col(0));
  Eigen::AlignedBox3d extent;
  for (std::uint32_t i : cluster) extent.extend(R.transpose() * points.points[i].cast<double>());
  box.X_FS.linear() = R;
  box.X_FS.translation() = R * extent.center();
  // A flat cluster still needs a solid box.
  box.shape.size_m = extent.sizes().cwiseMax(1e-3);
  return box;
}

bool IsHandle(const Placed<Box>& box, const Host& host) {
  const Vector3& size = box.shape.size_m;
  return host.nearest_m <= kRootGap_m && host.farthest_m >= kLeastReach_m &&
         size.x() >= kLeastLength_m && size.x() <= kMostLength_m && size.y() <= kMostWidth_m &&
         size.z() <= kMostThickness_m && size.x() >= kLeastElongation * size.y();
}

}  // namespace

std::vector<Handle> FindHandles(const OrientedPoints& points, const std::vector<ShapePart>& solids,
                                double spacing_m, std::vector<std::int32_t>& part_of_point,
                                const Work& work) {
  std::vector<std::uint32_t> rest;
  std::vector<Eigen::Vector3f> positions;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (part_of_point[i] != kUnexplained || !points.points[i].allFinite()) continue;
    rest.push_back(i);
    positions.push_back(points.points[i]);
  }
  std::vector<Handle> handles;
  if (solids.empty() || rest.size() < kLeastPoints) return handles;
  std::vector<std::uint32_t> all(rest.size());
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = static_cast<std::uint32_t>(k);
  const Connectivity connectivity(
      positions, static_cast<float>(std::max(kLeastCell_m, kCellSpacings * spacing_m)));
  for (std::vector<std::uint32_t>& cluster : connectivity.Components(all)) {
    work.Poll();
    if (cluster.size() < kLeastPoints) break;  // largest first
    for (std::uint32_t& k : cluster) k = rest[k];
    const Host host = NearestHost(points, cluster, solids, work);
    const Placed<Box> box = PrincipalBox(points, cluster);
    if (!IsHandle(box, host)) continue;
    Handle handle;
    handle.shape_index = static_cast<int>(host.solid);
    handle.point_count = static_cast<int>(cluster.size());
    handle.axis_O = box.X_FS.linear().col(0);
    handle.bounds = box;
    const auto label = static_cast<std::int32_t>(solids.size() + handles.size());
    for (std::uint32_t i : cluster) part_of_point[i] = label;
    handles.push_back(std::move(handle));
  }
  return handles;
}

}  // namespace cwm::perception
