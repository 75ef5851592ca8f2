#include "perception/scene/structures.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "perception/cloud/quantile.h"
#include "perception/scene/support_gaps.h"

namespace cwm::perception {
namespace {

constexpr double kLeastShare = 0.85;        // of a piece on its plane; the rest: handles, edges
constexpr double kNormalGate_cos = 0.9;     // 25 degrees
constexpr std::size_t kMostSamples = 400;   // of a piece, evenly spread
constexpr std::size_t kFewestSamples = 24;  // two independent ones: smaller pieces show no plane
constexpr double kBorderShare = 0.02;       // of the samples beyond either end of the reach

using Nodes = std::vector<std::uint32_t>;

std::vector<Nodes> SamplesOfPieces(const Pieces& pieces) {
  std::vector<Nodes> nodes(static_cast<std::size_t>(pieces.piece_count));
  for (std::size_t i = 0; i < pieces.of_node.size(); ++i) {
    const std::int32_t p = pieces.of_node[i];
    if (p < pieces.support_count) continue;
    nodes[static_cast<std::size_t>(p)].push_back(static_cast<std::uint32_t>(i));
  }
  for (Nodes& of_piece : nodes) {
    const std::size_t stride = (of_piece.size() + kMostSamples - 1) / kMostSamples;
    if (stride < 2) continue;
    Nodes sample;
    for (std::size_t k = 0; k < of_piece.size(); k += stride) sample.push_back(of_piece[k]);
    of_piece = std::move(sample);
  }
  return nodes;
}

double ShareOn(const Plane& plane, const OrientedPoints& nodes, const Nodes& sample) {
  const Eigen::Vector3f n = plane.normal.cast<float>();
  std::size_t on = 0;
  for (std::uint32_t i : sample) {
    on += std::abs(plane.Height_m(nodes.points[i])) <= nodes.MostOffPlane_m(i) &&
          nodes.normals[i].dot(n) > kNormalGate_cos;
  }
  return static_cast<double>(on) / static_cast<double>(sample.size());
}

// The largest of the extents along the plane, without its ragged ends.
double Reach_m(const Plane& plane, const OrientedPoints& nodes, const Nodes& sample) {
  const Matrix3 basis = BasisFromZ(plane.normal);
  double reach_m = 0;
  constexpr int kDirections = 8;  // over half a turn: cos(11 degrees) of the diagonal at least
  for (int k = 0; k < kDirections; ++k) {
    const double angle_rad = k * std::numbers::pi / kDirections;
    const Eigen::Vector3f along =
        (std::cos(angle_rad) * basis.col(0) + std::sin(angle_rad) * basis.col(1)).cast<float>();
    std::vector<float> places;
    for (std::uint32_t i : sample) places.push_back(along.dot(nodes.points[i]));
    const double low = Quantile(places, kBorderShare);
    reach_m = std::max(reach_m, Quantile(std::move(places), 1 - kBorderShare) - low);
  }
  return reach_m;
}

std::optional<Plane> StructurePlane(const OrientedPoints& nodes, const Nodes& sample) {
  if (sample.size() < kFewestSamples) return std::nullopt;
  Eigen::AlignedBox3f bounds;
  for (std::uint32_t i : sample) bounds.extend(nodes.points[i]);
  if (bounds.diagonal().norm() < kLongestThing_m) return std::nullopt;
  const std::optional<Plane> plane = FitPlane(nodes, sample, sample[0]);
  if (!plane || ShareOn(*plane, nodes, sample) < kLeastShare) return std::nullopt;
  if (Reach_m(*plane, nodes, sample) < kLongestThing_m) return std::nullopt;
  return plane;
}

}  // namespace

Structures FindStructures(const SurfaceGraph& graph, const Pieces& pieces, const SightMap& sight) {
  const std::vector<Nodes> samples = SamplesOfPieces(pieces);
  Structures out{.of_piece = std::vector<std::int32_t>(samples.size(), kNoStructure), .planes = {}};
  std::vector<std::size_t> first;  // of each structure, the piece that it was found by
  for (std::size_t p = 0; p < samples.size(); ++p) {
    const std::optional<Plane> plane = StructurePlane(graph.nodes(), samples[p]);
    if (!plane) continue;
    out.of_piece[p] = static_cast<std::int32_t>(out.planes.size());
    out.planes.push_back(*plane);
    first.push_back(p);
  }
  for (std::size_t p = 0; p < samples.size(); ++p) {
    if (out.of_piece[p] != kNoStructure || samples[p].size() < kFewestSamples) continue;
    for (std::size_t s = 0; s < out.planes.size() && out.of_piece[p] == kNoStructure; ++s) {
      if (ShareOn(out.planes[s], graph.nodes(), samples[p]) < kLeastShare) continue;
      if (!GapIsClosed(out.planes[s], graph.nodes(), samples[first[s]], samples[p], &sight)) {
        continue;
      }
      out.of_piece[p] = static_cast<std::int32_t>(s);
    }
  }
  return out;
}

}  // namespace cwm::perception
