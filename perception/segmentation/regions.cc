#include "perception/segmentation/regions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "perception/cloud/parallel_for.h"
#include "perception/cloud/tolerances.h"
#include "perception/segmentation/disjoint_sets.h"
#include "perception/segmentation/resting.h"
#include "perception/segmentation/structures.h"
#include "perception/segmentation/support_surface.h"

namespace cwm::perception {
namespace {

// chosen: the largest share of all points that is rejected as noise; points beyond it become
// residuals.
constexpr double kMaxRejectedShare = 0.005;
// chosen: the largest number of residuals; the last one takes the rest.
constexpr std::size_t kMaxResiduals = 256;

using NodeList = SupportSurface::NodeList;

// The nodes of each region of linked pieces that are neither supports nor structures.
std::vector<NodeList> NodesOfRegions(const SurfaceGraph& graph, const Pieces& pieces,
                                     const Structures& structures, const Work& work) {
  const auto piece_count = static_cast<std::size_t>(pieces.piece_count);
  const auto is_part = [&](std::int32_t p) {
    return p >= pieces.support_count &&
           structures.of_piece[static_cast<std::size_t>(p)] == kNoIndex;
  };
  DisjointSets sets(piece_count);
  for (std::uint32_t i : BorderNodes(graph, pieces, work)) {
    const std::int32_t a = pieces.of_node[i];
    if (!is_part(a)) continue;
    graph.ForEachLinked(i, [&](std::size_t j) {
      const std::int32_t b = pieces.of_node[j];
      if (a < b && is_part(b)) {
        sets.Join(static_cast<std::size_t>(a), static_cast<std::size_t>(b));
      }
    });
  }
  std::vector<NodeList> by_root(piece_count);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const std::int32_t p = pieces.of_node[i];
    if (!is_part(p)) continue;
    by_root[sets.Root(static_cast<std::size_t>(p))].push_back(static_cast<std::uint32_t>(i));
  }
  std::erase_if(by_root, [](const NodeList& nodes) { return nodes.empty(); });
  return by_root;
}

std::vector<Segment> NodesOfStructures(const Pieces& pieces, const Structures& structures) {
  std::vector<Segment> segments;
  for (const Plane& plane : structures.planes) segments.push_back({.nodes = {}, .plane = plane});
  for (std::size_t i = 0; i < pieces.of_node.size(); ++i) {
    if (pieces.of_node[i] < pieces.support_count) continue;
    const std::int32_t s = structures.of_piece[static_cast<std::size_t>(pieces.of_node[i])];
    if (s == kNoIndex) continue;
    segments[static_cast<std::size_t>(s)].nodes.push_back(static_cast<std::uint32_t>(i));
  }
  return segments;
}

// True if the larger part of the nodes is below the top of the support, or if their mean is by more
// than its error. Such a piece is linked to the edge of a board that something on the board juts
// over, or it is that edge.
bool LiesBelow(const NodeList& members, const Placed<Plate>& plate, const OrientedPoints& nodes) {
  const Pose X_SL = plate.X_FS.inverse(Eigen::Isometry);
  const auto count = static_cast<double>(members.size());
  double below = 0, sum_m = 0, sum_sigma_m = 0;
  for (std::uint32_t i : members) {
    const double height_m = (X_SL * nodes.points[i].cast<double>()).z();
    below += height_m < -kGate_sigma * nodes.sigma_m[i];
    sum_m += height_m;
    sum_sigma_m += nodes.sigma_m[i];
  }
  const double samples = std::max(1.0, count / double{nodes.points_per_sample});
  const double error_m = std::hypot(sum_sigma_m / count / std::sqrt(samples), double{nodes.warp_m});
  return below > kMajority * count || sum_m / count < -kGate_sigma * error_m;
}

// The nodes of the region that may stand on the support: those of pieces that do not lie below it.
NodeList WithoutBelow(const NodeList& region, const Pieces& pieces, const Placed<Plate>& plate,
                      const OrientedPoints& nodes) {
  std::map<std::int32_t, NodeList> of_piece;
  for (std::uint32_t i : region) of_piece[pieces.of_node[i]].push_back(i);
  std::erase_if(of_piece, [&](const auto& piece) { return LiesBelow(piece.second, plate, nodes); });
  NodeList above;
  for (std::uint32_t i : region) {
    if (of_piece.contains(pieces.of_node[i])) above.push_back(i);
  }
  return above;
}

// The highest support that carries the region, or -1.
std::int32_t SupportOf(const NodeList& region, const Pieces& pieces, const OrientedPoints& nodes,
                       const std::vector<SupportSurface>& floors,
                       const std::vector<Placed<Plate>>& plates) {
  std::int32_t best = -1;
  for (std::size_t s = 0; s < floors.size(); ++s) {
    if (!floors[s].Carries(region)) {
      const NodeList above = WithoutBelow(region, pieces, plates[s], nodes);
      if (above.empty() || above.size() == region.size() || !floors[s].Carries(above)) continue;
    }
    const double height = plates[s].X_FS.translation().z();
    if (best < 0 || height > plates[static_cast<std::size_t>(best)].X_FS.translation().z()) {
      best = static_cast<std::int32_t>(s);
    }
  }
  return best;
}

// Appends one object per piece of the region. Pieces below its support become residuals.
void AppendObjects(const Segment& region, const Pieces& pieces, const OrientedPoints& nodes,
                   const std::vector<Placed<Plate>>& plates, std::vector<Segment>& objects,
                   std::vector<Segment>& residuals) {
  std::map<std::int32_t, Segment> by_object;
  for (std::uint32_t i : region.nodes) {
    Segment& segment = by_object[pieces.of_node[i]];
    segment.supported_by = region.supported_by;
    segment.is_hanging = region.is_hanging;
    segment.nodes.push_back(i);
  }
  const Placed<Plate>& plate = plates[static_cast<std::size_t>(region.supported_by)];
  for (auto& [object, segment] : by_object) {
    if (LiesBelow(segment.nodes, plate, nodes)) {
      residuals.push_back({.nodes = std::move(segment.nodes)});
    } else {
      objects.push_back(std::move(segment));
    }
  }
}

// Nodes in no piece, grouped by neighbourhood in the coarse grid, largest group first.
std::vector<NodeList> GroupsOfStray(const CoarseCloud& coarse, const Pieces& pieces) {
  std::map<std::uint32_t, std::size_t> group_of_cell;
  NodeList stray;
  for (std::size_t i = 0; i < pieces.of_node.size(); ++i) {
    if (pieces.of_node[i] != kNoIndex) continue;
    stray.push_back(static_cast<std::uint32_t>(i));
    group_of_cell.try_emplace(coarse.grid.CellOfPoint(i), group_of_cell.size());
  }
  DisjointSets sets(group_of_cell.size());
  for (const auto& [c, group] : group_of_cell) {
    coarse.grid.ForEachWithin(1, coarse.grid.cell(c), [&, group = group](std::size_t other) {
      const auto found = group_of_cell.find(static_cast<std::uint32_t>(other));
      if (found != group_of_cell.end()) sets.Join(group, found->second);
    });
  }
  std::vector<NodeList> groups(group_of_cell.size());
  for (std::uint32_t i : stray) {
    groups[sets.Root(group_of_cell[coarse.grid.CellOfPoint(i)])].push_back(i);
  }
  std::erase_if(groups, [](const NodeList& nodes) { return nodes.empty(); });
  std::stable_sort(groups.begin(), groups.end(),
                   [](const NodeList& a, const NodeList& b) { return a.size() > b.size(); });
  return groups;
}

void KeepOrReject(const SurfaceGraph& graph, std::vector<NodeList> stray,
                  std::vector<Segment>& residuals, NodeList& rejected) {
  std::uint64_t all = 0;
  for (std::size_t i = 0; i < graph.size(); ++i) all += graph.weight(i);
  const auto may_reject = static_cast<std::uint64_t>(kMaxRejectedShare * static_cast<double>(all));
  std::uint64_t rejected_weight = 0;
  for (auto group = stray.rbegin(); group != stray.rend(); ++group) {  // smallest first
    std::uint64_t weight = 0;
    for (std::uint32_t i : *group) weight += graph.weight(i);
    if (rejected_weight + weight <= may_reject) {
      rejected_weight += weight;
      rejected.insert(rejected.end(), group->begin(), group->end());
    } else {
      residuals.push_back({.nodes = std::move(*group)});
    }
  }
  std::sort(rejected.begin(), rejected.end());
}

void LimitResiduals(std::vector<Segment>& residuals) {
  if (residuals.size() <= kMaxResiduals) return;
  NodeList& last = residuals[kMaxResiduals - 1].nodes;
  for (std::size_t k = kMaxResiduals; k < residuals.size(); ++k) {
    last.insert(last.end(), residuals[k].nodes.begin(), residuals[k].nodes.end());
  }
  std::sort(last.begin(), last.end());
  residuals.resize(kMaxResiduals);
}

}  // namespace

Regions FormRegions(const SurfaceGraph& graph, const CoarseCloud& coarse, const Pieces& pieces,
                    const std::vector<SupportPlane>& supports,
                    const std::vector<Placed<Plate>>& plates, const SightMap& sight,
                    const Work& work) {
  std::vector<SupportSurface> floors;
  for (std::size_t s = 0; s < supports.size(); ++s) {
    floors.emplace_back(graph, coarse, supports[s], plates[s], sight);
  }
  Regions out;
  const Structures structures = FindStructures(graph, pieces, sight);
  std::vector<Segment> residuals = NodesOfStructures(pieces, structures);
  std::vector<NodeList> regions = NodesOfRegions(graph, pieces, structures, work);
  std::vector<std::int32_t> support(regions.size());
  ParallelFor(regions.size(), 1, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r)
      support[r] = SupportOf(regions[r], pieces, graph.nodes(), floors, plates);
  });
  std::vector<Segment> hanging;
  for (std::size_t r = 0; r < regions.size(); ++r) {
    Segment region{.nodes = std::move(regions[r]), .supported_by = support[r]};
    if (support[r] >= 0) {
      AppendObjects(region, pieces, graph.nodes(), plates, out.segments, residuals);
    } else {
      hanging.push_back(std::move(region));
    }
  }
  AssignSupportsUnderStacks(graph.nodes(), plates, &sight, out.segments, hanging, work);
  for (Segment& region : hanging) {
    if (region.supported_by >= 0) {
      AppendObjects(region, pieces, graph.nodes(), plates, out.segments, residuals);
    } else {
      residuals.push_back(std::move(region));
    }
  }
  KeepOrReject(graph, GroupsOfStray(coarse, pieces), residuals, out.rejected);
  auto larger = [](const Segment& a, const Segment& b) { return a.nodes.size() > b.nodes.size(); };
  std::stable_sort(out.segments.begin(), out.segments.end(), larger);
  AssignResting(graph.nodes(), plates, &sight, out.segments, work);
  std::stable_sort(residuals.begin(), residuals.end(), larger);
  LimitResiduals(residuals);
  std::move(residuals.begin(), residuals.end(), std::back_inserter(out.segments));
  return out;
}

void MergeOnSupports(Regions& regions) {
  std::map<std::int32_t, Segment> on_support;
  std::vector<Segment> residuals;
  for (Segment& segment : regions.segments) {
    if (segment.supported_by < 0) {
      residuals.push_back(std::move(segment));
      continue;
    }
    Segment& all = on_support[segment.supported_by];
    all.supported_by = segment.supported_by;
    all.nodes.insert(all.nodes.end(), segment.nodes.begin(), segment.nodes.end());
  }
  regions.segments.clear();
  for (auto& [support, all] : on_support) {
    std::sort(all.nodes.begin(), all.nodes.end());
    regions.segments.push_back(std::move(all));
  }
  std::stable_sort(
      regions.segments.begin(), regions.segments.end(),
      [](const Segment& a, const Segment& b) { return a.nodes.size() > b.nodes.size(); });
  std::move(residuals.begin(), residuals.end(), std::back_inserter(regions.segments));
}

}  // namespace cwm::perception
