#include "perception/segmentation/structures.h"

#include <optional>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/segmentation/long_planes.h"
#include "perception/segmentation/support_gaps.h"

namespace cwm::perception {
namespace {

using Nodes = std::vector<std::uint32_t>;

std::vector<Nodes> SamplesOfPieces(const Pieces& pieces) {
  std::vector<Nodes> nodes(static_cast<std::size_t>(pieces.piece_count));
  for (std::size_t i = 0; i < pieces.of_node.size(); ++i) {
    const std::int32_t p = pieces.of_node[i];
    if (p < pieces.support_count) continue;
    nodes[static_cast<std::size_t>(p)].push_back(static_cast<std::uint32_t>(i));
  }
  for (Nodes& of_piece : nodes) {
    const std::size_t stride = (of_piece.size() + kMaxSamples - 1) / kMaxSamples;
    if (stride < 2) continue;
    Nodes sample;
    for (std::size_t k = 0; k < of_piece.size(); k += stride) sample.push_back(of_piece[k]);
    of_piece = std::move(sample);
  }
  return nodes;
}

std::optional<Plane> StructurePlane(const OrientedPoints& nodes, const Nodes& sample) {
  if (sample.size() < kTwoSamples) return std::nullopt;
  return LongPlane(nodes, sample, PlaneTolerance::kWide, kNearlyAll);
}

}  // namespace

Structures FindStructures(const SurfaceGraph& graph, const Pieces& pieces, const SightMap& sight) {
  const std::vector<Nodes> samples = SamplesOfPieces(pieces);
  Structures out{.of_piece = std::vector<std::int32_t>(samples.size(), kNoIndex), .planes = {}};
  std::vector<std::size_t> first;  // per structure, the piece that it was found by
  for (std::size_t p = 0; p < samples.size(); ++p) {
    const std::optional<Plane> plane = StructurePlane(graph.nodes(), samples[p]);
    if (!plane) continue;
    out.of_piece[p] = static_cast<std::int32_t>(out.planes.size());
    out.planes.push_back(*plane);
    first.push_back(p);
  }
  for (std::size_t p = 0; p < samples.size(); ++p) {
    if (out.of_piece[p] != kNoIndex || samples[p].size() < kTwoSamples) continue;
    for (std::size_t s = 0; s < out.planes.size() && out.of_piece[p] == kNoIndex; ++s) {
      if (ShareOn(out.planes[s], graph.nodes(), samples[p], PlaneTolerance::kUsual) < kNearlyAll)
        continue;
      if (!IsGapClosed(out.planes[s], graph.nodes(), samples[first[s]], samples[p], &sight)) {
        continue;
      }
      out.of_piece[p] = static_cast<std::int32_t>(s);
    }
  }
  return out;
}

}  // namespace cwm::perception
