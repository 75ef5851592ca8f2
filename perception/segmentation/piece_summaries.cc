#include "perception/segmentation/piece_summaries.h"

#include <algorithm>

#include "perception/cloud/parallel_for.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

PieceSummary ViewPiece(const SurfaceGraph& graph, const std::vector<std::uint32_t>& nodes) {
  PieceSummary view;
  if (nodes.empty()) return view;
  view.node_count = nodes.size();
  const std::size_t stride = (nodes.size() + kMaxSamples - 1) / kMaxSamples;
  std::vector<float> heights;
  for (std::size_t k = 0; k < nodes.size(); k += stride) {
    view.sample.push_back(nodes[k]);
    heights.push_back(graph.nodes().points[nodes[k]].z());
    view.bounds.extend(graph.nodes().points[nodes[k]].cast<double>());
  }
  for (std::uint32_t i : nodes) view.area_m2 += graph.area_m2(i);
  view.low_z_m = Quantile(heights, kMixedPixels);
  view.high_z_m = Quantile(heights, 1 - kMixedPixels);
  return view;
}

}  // namespace

PieceSummaries SummarizePieces(const SurfaceGraph& graph, const Pieces& pieces, const Work& work) {
  PieceSummaries views;
  for (std::uint32_t i : BorderNodes(graph, pieces, work)) {
    const std::int32_t a = pieces.of_node[i];
    graph.ForEachLinked(i, [&](std::size_t j) {
      const std::int32_t b = pieces.of_node[j];
      if (b == kNoIndex || b == a) return;
      Border& border = views.borders[{a, b}];
      ++border.links;
      border.level_links += std::max(0.0f, graph.nodes().normals[j].z());
    });
  }
  std::vector<std::vector<std::uint32_t>> nodes(static_cast<std::size_t>(pieces.piece_count));
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const std::int32_t a = pieces.of_node[i];
    if (a < pieces.support_count) continue;
    nodes[static_cast<std::size_t>(a)].push_back(static_cast<std::uint32_t>(i));
  }
  views.pieces.resize(nodes.size());
  ParallelFor(nodes.size(), 1, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) views.pieces[p] = ViewPiece(graph, nodes[p]);
  });
  for (const auto& [patch, support] : pieces.patch_of) {
    views.pieces[static_cast<std::size_t>(patch)].is_patch = true;
  }
  return views;
}

bool AreInContact(const PieceSummaries& views, std::size_t a, std::size_t b) {
  const auto border =
      views.borders.find({static_cast<std::int32_t>(a), static_cast<std::int32_t>(b)});
  return border != views.borders.end() &&
         IsContact(border->second.links,
                   std::min(views.pieces[a].node_count, views.pieces[b].node_count));
}

}  // namespace cwm::perception
