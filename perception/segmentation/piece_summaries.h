// The input of the tests for joining: a few evenly spread points of each piece, and the contacts of
// pieces.
#pragma once

#include <cstdint>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "perception/segmentation/pieces.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

struct PieceSummary {
  std::vector<std::uint32_t> sample;  // nodes, at most kMaxSamples, evenly spread
  std::size_t node_count = 0;
  double area_m2 = 0;
  double low_z_m = 0, high_z_m = 0;  // 2nd and 98th percentile of height
  Eigen::AlignedBox3d bounds;
  bool is_patch = false;  // lies on a support's plane (Pieces::patch_of)
};

// The contact of two pieces, seen from the first.
struct Border {
  int links = 0;
  float level_links = 0;  // sum over links of n . up of the second piece, where positive
};

struct PieceSummaries {
  std::vector<PieceSummary> pieces;                                 // per piece; empty for supports
  std::map<std::pair<std::int32_t, std::int32_t>, Border> borders;  // ordered, both directions
};

// True if two pieces share a good part of their outline; less is an incidental touch.
bool AreInContact(const PieceSummaries& views, std::size_t a, std::size_t b);

// chosen: smaller pieces do not determine a plane.
inline constexpr double kMinFace_m2 = 3e-4;

// chosen: mean n . up along the border of a face that objects rest on, including its rounded edge.
inline constexpr float kLevelBorder_cos = 0.6f;
// chosen: n . up of a vessel's floor.
inline constexpr float kFloor_cos = 0.8f;

// Up is z of the graph's frame.
PieceSummaries SummarizePieces(const SurfaceGraph& graph, const Pieces& pieces, const Work& work);

}  // namespace cwm::perception
