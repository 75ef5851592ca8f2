#include "perception/scene/regions.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "perception/cloud/parallel_for.h"
#include "perception/scene/disjoint_sets.h"
#include "perception/scene/resting.h"
#include "perception/scene/structures.h"
#include "perception/scene/support_gaps.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

// Chosen: things may jut out, the outline is true to one cell of 7.5 mm or more, and
// what lies beyond it by more than half would tip.
constexpr double kOverhang_m = 0.03;     // beyond the outline, and still over the support
constexpr double kLeastShareOver = 0.5;  // of a region's nodes
// Of a region that reaches out of the view, fewer nodes are over what is seen of the support; those
// that are below its top are of something beside it.
constexpr double kLeastShareOverSeen = 0.05, kMostShareBelow = 0.05, kLeastShareOutOfView = 0.1;
// Of a support whose near part something hides, a low table behind a counter, things stand so far before
// what is seen of it at most; asked on so many lines.
constexpr double kWidestHidden_m = 0.35;
constexpr std::size_t kAskedLines = 32;
constexpr double kBeforeFoot_m = 0.03;  // towards the sensor: no shadow of its own
constexpr double kFootHeight_m = 0.02;  // plus 3 sigma: the lowest points stand on the support
// A ball seen from above shows nothing of its underside: the tangent rays leave it at 0.3 of its
// radius, its grazing rim returns nothing up to 0.6, and the lowest tenth of what is seen reaches
// to 0.8, which is about this share of the width that is seen. Beyond 12 cm nothing that rolls is
// manipulated.
constexpr double kHiddenUndersideShare = 0.45;
constexpr double kWidestRound_m = 0.12;
// Seen more steeply it shows no foot at all, but where that is: of so many of its nodes, all but
// creases and mixed pixels lie on one sphere.
constexpr std::size_t kBallNodes = 400;
constexpr double kLeastOnBall = 0.9;
constexpr double kMostBelow = 0.5;         // of an object's nodes, below its support
constexpr double kLowestShare = 0.1;       // of a region's nodes are asked what holds them
constexpr double kLeastStanding = 0.2;     // of those; what hangs shows empty space below all
constexpr std::size_t kAskedNodes = 256;   // of a region's, evenly spread
constexpr double kFootprintCell_m = 0.01;  // the paper's octree leaves
// Cells of a support are so many cells of a footprint wide at most: where noise makes them wider, far
// away or in a scene of another scale, footprints are as coarse.
constexpr double kMostReach_cells = 6;
constexpr double kMostRejectedShare = 0.005;
constexpr std::size_t kMostResiduals = 256;  // more of them share the last one

using NodeList = std::vector<std::uint32_t>;

// Of the pieces that are neither supports nor structures.
std::vector<NodeList> NodesOfRegions(const SurfaceGraph& graph, const Pieces& pieces,
                                     const Structures& structures, const Work& work) {
  const auto piece_count = static_cast<std::size_t>(pieces.piece_count);
  const auto is_part = [&](std::int32_t p) {
    return p >= pieces.support_count &&
           structures.of_piece[static_cast<std::size_t>(p)] == kNoStructure;
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
    if (s == kNoStructure) continue;
    segments[static_cast<std::size_t>(s)].nodes.push_back(static_cast<std::uint32_t>(i));
  }
  return segments;
}

// One support as the regions above it see it.
class Floor {
 public:
  Floor(const SurfaceGraph& graph, const CoarseCloud& coarse, const SupportPlane& support,
        const Placed<Plate>& plate, const SightMap& sight)
      : graph_(graph),
        plate_(plate),
        sight_(sight),
        X_SL_(plate.X_FS.inverse(Eigen::Isometry)),
        cell_m_(std::max(kFootprintCell_m, coarse.grid.edge_m() / kMostReach_cells)) {
    for (std::uint32_t c : support.cells) occupied_.insert(CellOf(Local(coarse.cells.points[c])));
    reach_ = static_cast<int>(std::ceil(coarse.grid.edge_m() / cell_m_));
    for (const FootprintCell& cell : occupied_) extent_.extend(MiddleOf(cell));
  }

  bool Carries(const NodeList& region) const {
    const std::vector<std::size_t> over = NodesOver(region);
    const auto all = static_cast<double>(region.size()), share = static_cast<double>(over.size());
    if (share < kLeastShareOver * all) {
      const std::vector<std::size_t> whole(region.begin(), region.end());
      if (share >= kLeastShareOverSeen * all && HidesItsPlace(region)) {
        return StandsOrIsHidden(whole) && Footprint_m2(over) >= kSmallestFootprint_m2;
      }
      return IsOverHiddenPart(region) && StandsOrIsHidden(whole) &&
             Footprint_m2(whole) >= kSmallestFootprint_m2;
    }
    return (StandsOrIsHidden(over) || IsBallOnIt(over)) &&
           Footprint_m2(over) >= kSmallestFootprint_m2;
  }

 private:
  using FootprintCell = std::pair<int, int>;

  Vector3 Local(const Vector3f& p) const { return X_SL_ * p.cast<double>(); }
  FootprintCell CellOf(const Vector3& local) const {
    return {static_cast<int>(std::floor(local.x() / cell_m_)),
            static_cast<int>(std::floor(local.y() / cell_m_))};
  }

  Vector2 MiddleOf(const FootprintCell& cell) const {
    return {(cell.first + 0.5) * cell_m_, (cell.second + 0.5) * cell_m_};
  }

  std::vector<std::size_t> NodesOver(const NodeList& region) const {
    std::vector<std::size_t> over;
    std::map<FootprintCell, bool> inside;  // per cell: the outline is asked once
    auto latest = inside.end();            // nodes that follow each other are mostly in one cell
    for (std::uint32_t i : region) {
      const Vector3 local = Local(graph_.nodes().points[i]);
      if (local.z() < -kPlaneGate_sigma * graph_.nodes().sigma_m[i]) continue;
      if (const FootprintCell cell = CellOf(local);
          latest == inside.end() || latest->first != cell) {
        bool is_new;
        std::tie(latest, is_new) = inside.try_emplace(cell, false);
        if (is_new) {
          latest->second =
              OutsideOutline_m(plate_, graph_.nodes().points[i].cast<double>()) <= kOverhang_m;
        }
      }
      if (latest->second) over.push_back(i);
    }
    return over;
  }

  // Whether what of the support is below is out of the view or hidden, and nothing of the region is
  // lower.
  bool HidesItsPlace(const NodeList& region) const {
    std::size_t below = 0, hidden = 0, out_of_view = 0, asked = 0;
    for (std::size_t k = 0; k < region.size(); k += region.size() / kAskedNodes + 1, ++asked) {
      const float sigma = graph_.nodes().sigma_m[region[k]];
      Vector3 local = Local(graph_.nodes().points[region[k]]);
      below += local.z() < -kPlaneGate_sigma * sigma;
      local.z() = 0.5 * kFootHeight_m;
      const Visibility seen =
          sight_.Look((plate_.X_FS * local).cast<float>(), LargestJump_m(sigma));
      hidden += seen == Visibility::kHidden;
      out_of_view += seen == Visibility::kNoReturn;
    }
    const auto all = static_cast<double>(asked);
    return static_cast<double>(below) <= kMostShareBelow * all &&
           static_cast<double>(out_of_view) >= kLeastShareOutOfView * all &&
           static_cast<double>(hidden + out_of_view) >= kLeastShareOver * all;
  }

  // Whether the support, of which the rest was seen beside the region, may well go on below it: nothing
  // of the region is lower, something hides what is before its foot, and all that is between its foot
  // and what was seen of the support is hidden too.
  bool IsOverHiddenPart(const NodeList& region) const {
    const Vector2 sensor = Local(sight_.viewpoint()).head<2>();
    std::vector<std::pair<Vector2, float>>
        feet;  // and how far off the sensor may show what is there
    std::size_t below = 0, before = 0;
    for (std::size_t k = 0; k < region.size(); k += region.size() / kAskedLines + 1) {
      const float sigma = graph_.nodes().sigma_m[region[k]], jump_m = LargestJump_m(sigma);
      const Vector3 local = Local(graph_.nodes().points[region[k]]);
      const Vector2 foot = local.head<2>();
      if (extent_.exteriorDistance(foot) > kWidestHidden_m) return false;
      below += local.z() < -kPlaneGate_sigma * sigma;
      before += LookAt(foot + kBeforeFoot_m * (sensor - foot).normalized(), jump_m) ==
                Visibility::kHidden;
      feet.emplace_back(foot, jump_m);
    }
    const auto all = static_cast<double>(feet.size());
    if (static_cast<double>(below) > kMostShareBelow * all) return false;
    if (static_cast<double>(before) < kLeastHiddenGap * all) return false;
    const auto closed = std::ranges::count_if(
        feet, [&](const auto& foot) { return IsHiddenToSupport(foot.first, foot.second); });
    return static_cast<double>(closed) >= kLeastHiddenGap * all;
  }

  Visibility LookAt(const Vector2& foot, float jump_m) const {
    const Vector3 place = plate_.X_FS * Vector3(foot.x(), foot.y(), 0.5 * kFootHeight_m);
    return sight_.Look(place.cast<float>(), jump_m);
  }
  bool IsHiddenToSupport(const Vector2& from, float jump_m) const {
    Vector2 to = from;
    double nearest_m = kWidestHidden_m;
    for (const FootprintCell& cell : occupied_) {
      const double away_m = (MiddleOf(cell) - from).norm();
      if (away_m < nearest_m) nearest_m = away_m, to = MiddleOf(cell);
    }
    if (nearest_m >= kWidestHidden_m) return false;
    int through = 0;  // in a row: one may be a mixed pixel
    for (double at_m = 0; at_m < nearest_m && through < 2; at_m += cell_m_) {
      const Vector2 place = from + at_m / nearest_m * (to - from);
      through = LookAt(place, jump_m) == Visibility::kSeenThrough ? through + 1 : 0;
    }
    return through < 2;
  }

  // Through the nodes, the algebraic fit |p|^2 = 2 c . p + k (Kasa 1976).
  bool IsBallOnIt(const std::vector<std::size_t>& over) const {
    const std::size_t stride = over.size() / kBallNodes + 1;
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (std::size_t k = 0; k < over.size(); k += stride) {
      const Vector3 p = Local(graph_.nodes().points[over[k]]);
      const Eigen::Vector4d row(2 * p.x(), 2 * p.y(), 2 * p.z(), 1);
      normal += row * row.transpose();
      right += p.squaredNorm() * row;
    }
    const Eigen::Vector4d x = normal.ldlt().solve(right);
    const double radius_m = std::sqrt(x[3] + x.head<3>().squaredNorm());
    if (!(radius_m < 0.5 * kWidestRound_m + kFootHeight_m)) return false;
    std::size_t asked = 0, on = 0;
    float sigma = 0;
    for (std::size_t k = 0; k < over.size(); k += stride, ++asked) {
      sigma = std::max(sigma, graph_.nodes().sigma_m[over[k]]);
      const double off_m = (Local(graph_.nodes().points[over[k]]) - x.head<3>()).norm() - radius_m;
      on += std::abs(off_m) <= kPlaneGate_sigma * graph_.nodes().sigma_m[over[k]];
    }
    return static_cast<double>(on) >= kLeastOnBall * static_cast<double>(asked) &&
           std::abs(x[2] - radius_m) <= LargestJump_m(sigma);
  }

  // The lowest points touch the support, or nobody can see whether what they belong to does.
  bool StandsOrIsHidden(const std::vector<std::size_t>& over) const {
    std::vector<std::pair<double, std::size_t>> heights;
    Eigen::AlignedBox2d extent;
    for (std::size_t i : over) {
      const Vector3 local = Local(graph_.nodes().points[i]);
      heights.emplace_back(local.z(), i);
      extent.extend(Vector2(local.head<2>()));
    }
    const double width_m = std::min(extent.sizes().minCoeff(), kWidestRound_m);
    const double foot_m = std::max(kFootHeight_m, kHiddenUndersideShare * width_m);
    const auto low = heights.begin() + static_cast<std::ptrdiff_t>(
                                           kLowestShare * static_cast<double>(heights.size()));
    std::nth_element(heights.begin(), low, heights.end());
    std::size_t standing = 0, asked = 0;
    const auto count = static_cast<std::size_t>(low - heights.begin()) + 1;
    for (std::size_t k = 0; k < count; k += std::max<std::size_t>(1, count / 64), ++asked) {
      standing += StandsOrIsHidden(heights[k].second, heights[k].first, foot_m);
    }
    return static_cast<double>(standing) >= kLeastStanding * static_cast<double>(asked);
  }

  bool StandsOrIsHidden(std::size_t node, double height, double foot_m) const {
    const float sigma = graph_.nodes().sigma_m[node];
    if (height <= foot_m + kPlaneGate_sigma * sigma) return true;
    const Vector3f up = plate_.X_FS.linear().col(2).cast<float>();
    for (const float share : {0.25f, 0.5f, 0.75f}) {
      const Vector3f below = graph_.nodes().points[node] - share * static_cast<float>(height) * up;
      if (sight_.Look(below, LargestJump_m(sigma)) == Visibility::kSeenThrough) return false;
    }
    return true;
  }

  // Area of the region's projection that lies on cells of the support, right beside them (the
  // support below an object is hidden by it), or where nobody sees whether there is a support: what
  // stands behind a larger thing is surrounded by that one's shadow.
  double Footprint_m2(const std::vector<std::size_t>& over) const {
    std::set<FootprintCell> cells;
    auto latest = cells.end();
    for (std::size_t i : over) {
      const FootprintCell cell = CellOf(Local(graph_.nodes().points[i]));
      if (latest == cells.end() || *latest != cell) latest = cells.insert(cell).first;
    }
    std::size_t shared = 0;
    for (const FootprintCell& cell : cells) {
      bool touches = false;
      for (int dx = -reach_; dx <= reach_ && !touches; ++dx) {
        for (int dy = -reach_; dy <= reach_ && !touches; ++dy) {
          touches = occupied_.contains({cell.first + dx, cell.second + dy});
        }
      }
      shared += touches || IsHiddenAt(cell);
    }
    return static_cast<double>(shared) * cell_m_ * cell_m_;
  }

  bool IsHiddenAt(const FootprintCell& cell) const {
    const Vector2 middle = MiddleOf(cell);
    const Vector3 local(middle.x(), middle.y(), 0);
    return sight_.Look((plate_.X_FS * local).cast<float>(), static_cast<float>(kFootHeight_m)) ==
           Visibility::kHidden;
  }

  const SurfaceGraph& graph_;
  const Placed<Plate>& plate_;
  const SightMap& sight_;
  Pose X_SL_;
  double cell_m_;
  std::set<FootprintCell> occupied_;
  Eigen::AlignedBox2d extent_;  // of those
  int reach_ = 1;
};

// The highest support that carries the region, or -1.
std::int32_t SupportOf(const NodeList& region, const std::vector<Floor>& floors,
                       const std::vector<Placed<Plate>>& plates) {
  std::int32_t best = -1;
  for (std::size_t s = 0; s < floors.size(); ++s) {
    if (!floors[s].Carries(region)) continue;
    const double height = plates[s].X_FS.translation().z();
    if (best < 0 || height > plates[static_cast<std::size_t>(best)].X_FS.translation().z()) {
      best = static_cast<std::int32_t>(s);
    }
  }
  return best;
}

// Of an edge of a board that something juts over, to which it is linked: below what the board carries.
bool LiesBelow(const NodeList& members, const Placed<Plate>& plate, const OrientedPoints& nodes) {
  const Pose X_SL = plate.X_FS.inverse(Eigen::Isometry);
  const auto below = std::ranges::count_if(members, [&](std::uint32_t i) {
    return (X_SL * nodes.points[i].cast<double>()).z() < -kPlaneGate_sigma * nodes.sigma_m[i];
  });
  return static_cast<double>(below) > kMostBelow * static_cast<double>(members.size());
}

// One object for each piece of the region, but for those below its support, which are residuals.
void AppendObjects(const Segment& region, const Pieces& pieces, const OrientedPoints& nodes,
                   const std::vector<Placed<Plate>>& plates, std::vector<Segment>& objects,
                   std::vector<Segment>& residuals) {
  std::map<std::int32_t, Segment> by_object;
  for (std::uint32_t i : region.nodes) {
    Segment& segment = by_object[pieces.of_node[i]];
    segment.supported_by = region.supported_by;
    segment.hangs = region.hangs;
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
    if (pieces.of_node[i] != kNoPiece) continue;
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
  const auto may_reject = static_cast<std::uint64_t>(kMostRejectedShare * static_cast<double>(all));
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
  if (residuals.size() <= kMostResiduals) return;
  NodeList& last = residuals[kMostResiduals - 1].nodes;
  for (std::size_t k = kMostResiduals; k < residuals.size(); ++k) {
    last.insert(last.end(), residuals[k].nodes.begin(), residuals[k].nodes.end());
  }
  std::sort(last.begin(), last.end());
  residuals.resize(kMostResiduals);
}

}  // namespace

Regions FormRegions(const SurfaceGraph& graph, const CoarseCloud& coarse, const Pieces& pieces,
                    const std::vector<SupportPlane>& supports,
                    const std::vector<Placed<Plate>>& plates, const SightMap& sight,
                    const Work& work) {
  std::vector<Floor> floors;
  for (std::size_t s = 0; s < supports.size(); ++s) {
    floors.emplace_back(graph, coarse, supports[s], plates[s], sight);
  }
  Regions out;
  const Structures structures = FindStructures(graph, pieces, sight);
  std::vector<Segment> residuals = NodesOfStructures(pieces, structures);
  std::vector<NodeList> regions = NodesOfRegions(graph, pieces, structures, work);
  std::vector<std::int32_t> support(regions.size());
  ParallelFor(regions.size(), 1, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) support[r] = SupportOf(regions[r], floors, plates);
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
  FindSupportsUnderStacks(graph.nodes(), plates, &sight, out.segments, hanging, work);
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
  FindWhatTheyRestOn(graph.nodes(), plates, &sight, out.segments, work);
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
