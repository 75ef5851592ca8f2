#include "perception/segmentation/long_planes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/segmentation/connected_sets.h"

namespace cwm::perception {
namespace {

using Nodes = std::vector<std::uint32_t>;

// The largest extent of the members along the plane, in metres, without the outermost members.
double Reach_m(const Plane& plane, const OrientedPoints& points, const Nodes& members) {
  const Matrix3 basis = BasisFromZ(plane.normal);
  double reach_m = 0;
  // chosen: directions over half a turn: one of them is within 11 degrees of the diagonal and shows
  // it 2 percent shorter.
  constexpr int kReachDirections = 8;
  for (int k = 0; k < kReachDirections; ++k) {
    const double angle_rad = k * std::numbers::pi / kReachDirections;
    const Eigen::Vector3f along =
        (std::cos(angle_rad) * basis.col(0) + std::sin(angle_rad) * basis.col(1)).cast<float>();
    std::vector<float> places;
    for (std::uint32_t i : members) places.push_back(along.dot(points.points[i]));
    const double low = Quantile(places, kMixedPixels);
    reach_m = std::max(reach_m, Quantile(std::move(places), 1 - kMixedPixels) - low);
  }
  return reach_m;
}

bool IsLong(const OrientedPoints& points, std::span<const std::uint32_t> members) {
  Eigen::AlignedBox3f bounds;
  for (std::uint32_t i : members) bounds.extend(points.points[i]);
  return bounds.diagonal().norm() >= float{kMaxObjectLength_m};
}

Nodes SampleOf(const Nodes& members) {
  Nodes sample;
  const std::size_t stride = std::max<std::size_t>(1, members.size() / kMaxSamples);
  for (std::size_t k = 0; k < members.size(); k += stride) sample.push_back(members[k]);
  return sample;
}

}  // namespace

bool IsOnPlane(const Plane& plane, const OrientedPoints& points, std::size_t i,
               PlaneTolerance tolerance) {
  const float tolerance_m = tolerance == PlaneTolerance::kUsual ? points.UsualPlaneTolerance_m(i)
                                                                : points.WidePlaneTolerance_m(i);
  return std::abs(plane.Height_m(points.points[i])) <= tolerance_m &&
         points.normals[i].dot(plane.normal.cast<float>()) > kFacing_cos;
}

double ShareOn(const Plane& plane, const OrientedPoints& points,
               std::span<const std::uint32_t> members, PlaneTolerance tolerance) {
  const auto on = std::ranges::count_if(
      members, [&](auto i) { return IsOnPlane(plane, points, i, tolerance); });
  return static_cast<double>(on) / static_cast<double>(members.size());
}

std::optional<Plane> LongPlane(const OrientedPoints& points, std::span<const std::uint32_t> members,
                               PlaneTolerance tolerance, double min_share) {
  if (members.empty() || !IsLong(points, members)) return std::nullopt;
  const std::optional<Plane> plane = FitPlane(points, members, members[0]);
  if (!plane || ShareOn(*plane, points, members, tolerance) < min_share) return std::nullopt;
  Nodes on;
  std::ranges::copy_if(members, std::back_inserter(on),
                       [&](auto i) { return IsOnPlane(*plane, points, i, tolerance); });
  if (Reach_m(*plane, points, on) < kMaxObjectLength_m) return std::nullopt;
  return plane;
}

std::vector<Plane> LabelLongPlanes(const SurfaceGraph& graph, std::vector<std::int32_t>& classes,
                                   const Work& work) {
  const OrientedPoints& nodes = graph.nodes();
  const ConnectedSets sets = FindConnectedSets(graph, classes, work);
  std::vector<Nodes> members(sets.count());
  for (std::uint32_t i = 0; i < graph.size(); ++i) {
    if (classes[i] == 0) members[static_cast<std::size_t>(sets.of_node[i])].push_back(i);
  }
  std::vector<Plane> planes;
  for (Nodes& left : members) {
    work.Poll();
    while (const auto plane =
               LongPlane(nodes, SampleOf(left), PlaneTolerance::kUsual, kMinInlierShare)) {
      std::erase_if(left, [&](std::uint32_t i) {
        if (!IsOnPlane(*plane, nodes, i, PlaneTolerance::kUsual)) return false;
        classes[i] = static_cast<std::int32_t>(planes.size()) + 1;
        return true;
      });
      planes.push_back(*plane);
    }
  }
  return planes;
}

}  // namespace cwm::perception
