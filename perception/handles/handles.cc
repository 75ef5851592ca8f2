#include "perception/handles/handles.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <variant>

#include "collision/geometry/signed_distance.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/seen_width.h"
#include "perception/cloud/slenderness.h"
#include "perception/cloud/tolerances.h"
#include "perception/fit/solid.h"
#include "perception/search/connectivity.h"
#include "perception/solids/explain.h"
#include "perception/solids/extended_distance.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

// chosen: distance from a solid's surface. A handle begins nearer to it and reaches farther out,
// which the roughness of a wall does not.
constexpr double kRoot_m = 0.015;

// True if nearly all points are within their noise of the ground: an object's foot may take points
// of its support, which belong to the band above the support or are a little above it by noise.
// `ground` is in the points' frame.
bool LiesOn(const OrientedPoints& points, const std::vector<std::uint32_t>& members,
            const Ground& ground) {
  if (!ground.known || members.empty()) return false;
  std::vector<double> heights_m;
  double sigma_m = 0;
  for (std::uint32_t i : members) {
    heights_m.push_back(ground.Height_m(points.points[i].cast<double>()));
    sigma_m = std::max(sigma_m, double{points.sigma_m[i]});
  }
  return Quantile(std::move(heights_m), kNearlyAll) <= kNoiseReach_sigma * sigma_m;
}

// True if most points of the cluster lie on the host's surface extended beyond its ends. They are
// then more of the host rather than a handle.
bool ExtendsHost(const OrientedPoints& points, const std::vector<std::uint32_t>& cluster,
                 const ShapePart& host) {
  const Pose X_SL = host.X_OS.inverse(Eigen::Isometry);
  std::size_t on = 0;
  for (std::uint32_t i : cluster) {
    const Vector3 p = X_SL * points.points[i].cast<double>();
    on += ExtendedDistance_m(host.shape, p) <= AssignmentTolerance_m(points.sigma_m[i]);
  }
  return 2 * on > cluster.size();
}

struct Host {
  std::size_t solid = 0;
  double nearest_m = std::numeric_limits<double>::infinity();
  double farthest_m = 0;
};

Eigen::Vector3f ExtentOf(const OrientedPoints& points, const std::vector<std::uint32_t>& cluster) {
  Eigen::AlignedBox3f extent;
  for (std::uint32_t i : cluster) extent.extend(points.points[i]);
  return extent.sizes();
}

Host NearestHost(const OrientedPoints& points, const std::vector<std::uint32_t>& cluster,
                 const std::vector<ShapePart>& solids, const Work& work) {
  PollEvery poll(work, ItemsPerChunk(200ns));
  Host best;
  for (std::size_t k = 0; k < solids.size(); ++k) {
    const Pose X_SL = solids[k].X_OS.inverse();
    Host host{k};
    for (std::uint32_t i : cluster) {
      poll();
      const double distance_m = SignedDistance_m(solids[k], X_SL * points.points[i].cast<double>());
      host.nearest_m = std::min(host.nearest_m, std::abs(distance_m));
      host.farthest_m = std::max(host.farthest_m, distance_m);
    }
    if (host.nearest_m < best.nearest_m) best = host;
  }
  return best;
}

// The box along the axes of largest, middle and least extent.
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

bool IsHandle(const OrientedPoints& points, const std::vector<std::uint32_t>& cluster,
              double spacing_m, const Placed<Box>& box, const Host& host) {
  if (host.nearest_m > kRoot_m || host.farthest_m < kRoot_m) return false;
  if (box.shape.size_m.z() > kMaxBowReach_m) return false;
  std::vector<Eigen::Vector3f> positions;
  for (std::uint32_t i : cluster) positions.push_back(points.points[i]);
  const Slenderness bar = MeasureSlenderness(positions, points.viewpoint, spacing_m);
  return bar.length_m >= kMinHandleLength_m && bar.length_m <= kMaxHandleLength_m &&
         bar.width_m <= kMaxHandleWidth_m && bar.length_m >= kMinElongation * bar.width_m &&
         SeenWidth_m(positions, points.viewpoint) <= kMaxSeenHandleWidth_m;
}

void AddHandle(const Placed<Box>& box, const std::vector<std::uint32_t>& cluster, int shape_index,
               ObjectModel& model) {
  const auto label = static_cast<std::int32_t>(model.shapes.size() + model.handles.size());
  for (std::uint32_t i : cluster) model.part_of_point[i] = label;
  Handle& handle = model.handles.emplace_back();
  handle.shape_index = shape_index;
  handle.point_count = static_cast<int>(cluster.size());
  handle.axis_O = box.X_FS.linear().col(0);
  handle.bounds = box;
}

std::vector<std::vector<std::uint32_t>> MembersOfSolids(
    const std::vector<std::int32_t>& part_of_point, std::size_t count) {
  std::vector<std::vector<std::uint32_t>> members(count);
  for (std::uint32_t i = 0; i < part_of_point.size(); ++i) {
    if (part_of_point[i] == kUnexplained) continue;
    members[static_cast<std::size_t>(part_of_point[i])].push_back(i);
  }
  return members;
}

// True if the small solid lies on the axis of a round host, within half of its radius and 20
// degrees, like a bottle's neck or a knob on a lid.
bool IsCoaxial(const ShapePart& small, const ShapePart& host) {
  const auto* cylinder = std::get_if<Cylinder>(&host.shape);
  const auto* cone = std::get_if<Cone>(&host.shape);
  if (cylinder == nullptr && cone == nullptr) return false;
  const double radius_m =
      cylinder ? cylinder->radius_m : 0.5 * (cone->radius_bottom_m + cone->radius_top_m);
  const Vector3 at = (host.X_OS.inverse(Eigen::Isometry) * small.X_OS).translation();
  if (2 * at.head<2>().norm() > radius_m) return false;
  const Vector3 axis = host.X_OS.linear().col(2), its_axis = small.X_OS.linear().col(2);
  return axis.cross(its_axis).norm() < kSteep_sin || std::holds_alternative<Sphere>(small.shape);
}

void Drop(const std::vector<char>& drop, std::vector<ShapePart>& solids,
          std::vector<std::int32_t>& part_of_point) {
  std::vector<std::int32_t> renamed(solids.size());
  std::vector<ShapePart> kept;
  for (std::size_t k = 0; k < solids.size(); ++k) {
    renamed[k] = drop[k] ? kUnexplained : static_cast<std::int32_t>(kept.size());
    if (!drop[k]) kept.push_back(std::move(solids[k]));
  }
  solids = std::move(kept);
  for (std::int32_t& part : part_of_point) {
    if (part != kUnexplained) part = renamed[static_cast<std::size_t>(part)];
  }
}

// True if most of the cluster belongs to a solid that has twice as many points beside the vessel's
// wall, or to a ball, which no ear resembles. Points of the solid on the wall do not count, because
// there the solid mixes both.
bool IsPartOfSolid(const std::vector<std::uint32_t>& cluster, const std::vector<ShapePart>& solids,
                   const std::vector<std::size_t>& beside_wall,
                   const std::vector<std::int32_t>& part_of_point) {
  std::vector<std::size_t> shared(beside_wall.size(), 0);
  for (std::uint32_t i : cluster) {
    if (part_of_point[i] != kUnexplained) ++shared[static_cast<std::size_t>(part_of_point[i])];
  }
  for (std::size_t k = 0; k < shared.size(); ++k) {
    if (2 * shared[k] < cluster.size()) continue;
    if (std::holds_alternative<Sphere>(solids[k].shape)) return true;
    if (beside_wall[k] >= 2 * shared[k]) return true;
  }
  return false;
}

// The number of points of each solid that stand out from the vessel's walls.
std::vector<std::size_t> CountBesideWall(const Vessel& vessel, const OrientedPoints& points,
                                         const std::vector<std::int32_t>& part_of_point,
                                         std::size_t solid_count) {
  std::vector<std::size_t> count(solid_count, 0);
  for (std::uint32_t i : vessel.ProtrudingPoints(points, std::vector<char>(points.size(), 1))) {
    if (part_of_point[i] != kUnexplained) ++count[static_cast<std::size_t>(part_of_point[i])];
  }
  return count;
}

}  // namespace

void DropSolidsOfHandles(const OrientedPoints& points, double spacing_m, const Ground& ground,
                         std::vector<ShapePart>& solids, std::vector<std::int32_t>& part_of_point,
                         const Work& work) {
  const std::vector<std::vector<std::uint32_t>> members =
      MembersOfSolids(part_of_point, solids.size());
  const auto main = std::max_element(members.begin(), members.end(),
                                     [](auto& a, auto& b) { return a.size() < b.size(); });
  if (main == members.end()) return;
  const std::vector<ShapePart> host{solids[static_cast<std::size_t>(main - members.begin())]};
  const Pose X_SL = host[0].X_OS.inverse(Eigen::Isometry);
  const auto host_part = static_cast<std::int32_t>(main - members.begin());
  std::vector<char> drop(solids.size(), 0);
  for (std::size_t k = 0; k < solids.size(); ++k) {
    work.Poll();
    // An ear also fits a bit of a cylinder, but not a ball.
    const bool may_be = members[k].size() >= kFiveSamples && !IsCoaxial(solids[k], host[0]) &&
                        !std::holds_alternative<Sphere>(solids[k].shape) &&
                        2 * members[k].size() < main->size();
    drop[k] = may_be && !LiesOn(points, members[k], ground) &&
              IsHandle(points, members[k], spacing_m, PrincipalBox(points, members[k]),
                       NearestHost(points, members[k], host, work));
    if (!drop[k]) continue;
    // The dropped solid also held points of the host's wall beside the handle.
    for (const std::uint32_t i : members[k]) {
      const double off_m = SignedDistance_m(host[0], X_SL * points.points[i].cast<double>());
      if (std::abs(off_m) <= AssignmentTolerance_m(points.sigma_m[i])) part_of_point[i] = host_part;
    }
  }
  Drop(drop, solids, part_of_point);
}

Clusters HandlesOfVessel(const Vessel& vessel, const OrientedPoints& points, const Ground& ground,
                         const std::vector<ShapePart>& solids,
                         const std::vector<std::int32_t>& part_of_point, const Work& work) {
  const std::vector<std::size_t> beside_wall =
      CountBesideWall(vessel, points, part_of_point, solids.size());
  auto [handles, spouts] = vessel.FindFixedParts(points, std::vector<char>(points.size(), 1), work);
  std::erase_if(handles, [&](const std::vector<std::uint32_t>& handle) {
    return LiesOn(points, handle, ground) ||
           IsPartOfSolid(handle, solids, beside_wall, part_of_point);
  });
  std::vector<char> unexplained(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i) unexplained[i] = part_of_point[i] < 0;
  for (const Clusters* known : {&handles, &spouts}) {
    for (const std::vector<std::uint32_t>& cluster : *known) {
      for (std::uint32_t i : cluster) unexplained[i] = 0;
    }
  }
  if (solids.empty()) return handles;
  Clusters more = vessel.FindFixedParts(points, unexplained, work).handles;
  std::erase_if(more, [&](const std::vector<std::uint32_t>& handle) {
    return LiesOn(points, handle, ground);
  });
  std::move(more.begin(), more.end(), std::back_inserter(handles));
  vessel.MergeHandles(points, handles);
  return handles;
}

void RemoveFromSolids(const Clusters& clusters, std::vector<ShapePart>& solids,
                      std::vector<std::int32_t>& part_of_point) {
  const Clusters before = MembersOfSolids(part_of_point, solids.size());
  for (const std::vector<std::uint32_t>& cluster : clusters) {
    for (std::uint32_t i : cluster) part_of_point[i] = kUnexplained;
  }
  const Clusters after = MembersOfSolids(part_of_point, solids.size());
  std::vector<char> drop(solids.size(), 0);
  for (std::size_t k = 0; k < solids.size(); ++k) drop[k] = 2 * after[k].size() < before[k].size();
  Drop(drop, solids, part_of_point);
}

void FindHandles(const OrientedPoints& points, double spacing_m, const Ground& ground,
                 ObjectModel& model, const Work& work) {
  std::vector<std::uint32_t> rest;
  std::vector<Eigen::Vector3f> positions;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (model.part_of_point[i] != kUnexplained || !points.points[i].allFinite()) continue;
    rest.push_back(i);
    positions.push_back(points.points[i]);
  }
  if (model.shapes.empty() || rest.size() < kFiveSamples) return;
  std::vector<std::uint32_t> all(rest.size());
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = static_cast<std::uint32_t>(k);
  const Connectivity connectivity(
      positions, static_cast<float>(std::max(kNoiseReach_m, kSpacingsPerCell * spacing_m)));
  const std::vector<std::vector<std::uint32_t>> of_solids =
      MembersOfSolids(model.part_of_point, model.shapes.size());
  for (std::vector<std::uint32_t>& cluster : connectivity.Components(all)) {
    work.Poll();
    if (cluster.size() < kFiveSamples) break;  // largest first
    for (std::uint32_t& k : cluster) k = rest[k];
    if (ExtentOf(points, cluster).maxCoeff() > kMaxHandleLength_m)
      continue;  // its length is at least that
    if (LiesOn(points, cluster, ground)) continue;
    const Host host = NearestHost(points, cluster, model.shapes, work);
    const std::size_t of_host = of_solids[host.solid].size();
    const bool is_small = of_host == 0 || 2 * cluster.size() <= of_host;
    if (!is_small || std::holds_alternative<Plate>(model.shapes[host.solid].shape)) {
      continue;
    }
    const Placed<Box> box = PrincipalBox(points, cluster);
    if (!IsHandle(points, cluster, spacing_m, box, host) ||
        ExtendsHost(points, cluster, model.shapes[host.solid])) {
      continue;
    }
    AddHandle(box, cluster, static_cast<int>(host.solid), model);
  }
}

void AddHandles(const OrientedPoints& points, const Clusters& clusters, ObjectModel& model,
                const Work& work) {
  for (const std::vector<std::uint32_t>& cluster : clusters) {
    const Host host = NearestHost(points, cluster, model.shapes, work);
    const bool grew_from_it = host.nearest_m <= kRoot_m;
    AddHandle(PrincipalBox(points, cluster), cluster,
              grew_from_it ? static_cast<int>(host.solid) : kNoShape, model);
  }
}

}  // namespace cwm::perception
