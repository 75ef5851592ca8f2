#include "perception/segmentation/structure_plates.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/segmentation/long_planes.h"

namespace cwm::perception {
namespace {

using NodeIndices = std::vector<std::uint32_t>;

// chosen: the faces of one structure: a cabinet with doors and drawers that stand out from it.
constexpr std::size_t kMaxPlates = 4;

SupportPlane FaceOn(const Plane& plane, const NodeIndices& members, const CoarseCloud& coarse) {
  SupportPlane face{.plane = plane, .cells = {}, .area_m2 = 0};
  for (std::uint32_t i : members) face.cells.push_back(coarse.grid.CellOfPoint(i));
  std::sort(face.cells.begin(), face.cells.end());
  face.cells.erase(std::unique(face.cells.begin(), face.cells.end()), face.cells.end());
  const double edge_m = coarse.grid.edge_m();
  face.area_m2 = static_cast<double>(face.cells.size()) * edge_m * edge_m;
  // The given plane was fitted to a sample.
  face.plane = RefinePlane(plane, coarse.cells, face.cells).value_or(plane);
  return face;
}

// The plane of the larger part of the members; empty if they are too few for a face.
std::optional<Plane> PlaneOfMost(const NodeIndices& members, const CoarseCloud& coarse,
                                 const OrientedPoints& nodes) {
  NodeIndices sample;
  const std::size_t stride = (members.size() + kMaxSamples - 1) / kMaxSamples;
  for (std::size_t k = 0; k < members.size(); k += stride) sample.push_back(members[k]);
  if (sample.empty()) return std::nullopt;
  const std::optional<Plane> plane = FitPlane(nodes, sample, sample.front());
  if (!plane || ShareOn(*plane, nodes, sample, PlaneTolerance::kUsual) < kMajority)
    return std::nullopt;
  if (FaceOn(*plane, members, coarse).area_m2 < kMinSupport_m2) return std::nullopt;
  return plane;
}

}  // namespace

std::vector<Placed<Plate>> PlatesOfStructure(const Segment& segment, const CoarseCloud& coarse,
                                             const OrientedPoints& nodes, const SightMap* sight) {
  std::vector<Placed<Plate>> plates;
  NodeIndices left = segment.nodes;
  std::optional<Plane> plane = segment.plane;
  for (std::size_t k = 0; plane && k < kMaxPlates; ++k) {
    const SupportPlane face = FaceOn(*plane, left, coarse);
    for (BoundedSupport& part : BoundSupport(face, coarse, nodes, sight)) {
      plates.push_back(std::move(part.plate));
    }
    std::erase_if(left, [&](std::uint32_t i) {
      return std::abs(face.plane.Height_m(nodes.points[i])) <= kGate_sigma * nodes.sigma_m[i];
    });
    plane = PlaneOfMost(left, coarse, nodes);
  }
  return plates;
}

}  // namespace cwm::perception
