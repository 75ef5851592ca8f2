#include "perception/segmentation/resting.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "collision/geometry/polygon.h"
#include "perception/cloud/parallel_for.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {
namespace {

// derived: the largest horizontal distance of contact, in cells: the rounded edge of a crease.
constexpr int kContact_cells = static_cast<int>(kEdgeLoss_m / kFootprintCell_m);
// chosen: the least share of the lowest nodes that touch; the others may overhang or face away.
constexpr double kMinTouching = 0.3;
// chosen: the least number of footprint cells that make a top.
constexpr std::size_t kMinTop_cells = 4;
// chosen: the least number of footprint cells that show that the space over them is hidden.
constexpr std::size_t kMinHidden_cells = 3;

using Cell = std::pair<int, int>;

Cell CellOf(const Vector2& p) {
  return {static_cast<int>(std::floor(p.x() / kFootprintCell_m)),
          static_cast<int>(std::floor(p.y() / kFootprintCell_m))};
}
Vector2 CenterOf(const Cell& cell) {
  return {(cell.first + 0.5) * kFootprintCell_m, (cell.second + 0.5) * kFootprintCell_m};
}

// How deep a place lies in a convex polygon, in metres; negative outside. A polygon without area,
// of an object that shows one upright face, has only an outside.
double DepthIn_m(const Polygon& hull, const Vector2& p) {
  if (hull.size() < 3) return -(NearestOnBorder(hull, p) - p).norm();
  double depth = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0, j = hull.size() - 1; i < hull.size(); j = i++) {
    const Vector2 edge = hull[i] - hull[j], to = p - hull[j];
    depth = std::min(depth, (edge.x() * to.y() - edge.y() * to.x()) / edge.norm());
  }
  return depth;
}

// An object over its support, in the plate's frame.
struct Standing {
  std::size_t segment = 0;
  std::map<Cell, double> top_m;  // per cell of the footprint, the largest height of the object
  std::vector<Vector3> low;      // the lowest tenth of the nodes
  Polygon hull;                  // of the footprint
  double foot_m = 0;
  double band_m = 0;        // heights within this are equal
  bool is_hanging = false;  // rests on another object, whatever share of it lies over that one

  Standing(std::size_t index, const Segment& s, const OrientedPoints& nodes, const Pose& X_PL)
      : segment(index), is_hanging(s.is_hanging) {
    std::vector<Vector3> places;
    std::vector<float> sigma;
    auto column = top_m.end();  // consecutive nodes are mostly in one cell
    const std::size_t stride = s.nodes.size() / kMaxTestedNodes + 1;
    for (std::size_t k = 0; k < s.nodes.size(); k += stride) {
      const std::uint32_t i = s.nodes[k];
      places.push_back(X_PL * nodes.points[i].cast<double>());
      sigma.push_back(nodes.sigma_m[i]);
      const Cell cell = CellOf(places.back().head<2>());
      if (column == top_m.end() || column->first != cell) {
        column = top_m.try_emplace(cell, places.back().z()).first;
      }
      column->second = std::max(column->second, places.back().z());
    }
    const auto below = [](const Vector3& a, const Vector3& b) { return a.z() < b.z(); };
    const auto count = static_cast<double>(places.size());
    const auto lowest = places.begin() + static_cast<std::ptrdiff_t>((1 - kNearlyAll) * count);
    const auto foot = places.begin() + static_cast<std::ptrdiff_t>(kMixedPixels * count);
    std::nth_element(places.begin(), lowest, places.end(), below);
    low.assign(places.begin(), lowest + 1);
    std::nth_element(places.begin(), foot, lowest + 1, below);
    foot_m = foot->z();
    band_m = MaxJump_m(Median(std::move(sigma)));
    std::vector<Vector2> corners;
    for (const auto& [cell, top] : top_m) corners.push_back(CenterOf(cell));
    hull = ConvexHull(std::move(corners));
  }
};

// True if enough of the upper one's lowest nodes are beside the lower one's top.
bool Touches(const Standing& upper, const Standing& lower) {
  std::size_t touching = 0;
  for (const Vector3& p : upper.low) {
    const Cell cell = CellOf(p.head<2>());
    bool found = false;
    for (int n = 0; n < (2 * kContact_cells + 1) * (2 * kContact_cells + 1) && !found; ++n) {
      const int dx = n % (2 * kContact_cells + 1) - kContact_cells;
      const int dy = n / (2 * kContact_cells + 1) - kContact_cells;
      const auto at = lower.top_m.find({cell.first + dx, cell.second + dy});
      found = at != lower.top_m.end() && std::abs(at->second - p.z()) <= upper.band_m;
    }
    touching += found;
  }
  return static_cast<double>(touching) >= kMinTouching * static_cast<double>(upper.low.size());
}

// True if the lower one's top within the upper one's footprint (grown by a cell, the blur) is at
// the height of the upper one's foot. Higher parts than nearly all of it are a handle or noise.
bool EndsBelow(const Standing& upper, const Standing& lower) {
  std::vector<double> tops;
  for (const auto& [cell, top] : lower.top_m) {
    if (DepthIn_m(upper.hull, CenterOf(cell)) >= -kFootprintCell_m) tops.push_back(top);
  }
  if (tops.size() < kMinTop_cells) return false;
  return std::abs(Quantile(std::move(tops), kNearlyAll) - upper.foot_m) <= upper.band_m;
}

// Share of the lower one's footprint under the hanging upper one if that hides the space between
// its foot and the visible end of the lower one; else 0. Mixed pixels, and the lower one's face as
// far as the upper one's edge leaves it visible, are allowed for.
double ShareHiddenBelow(const Standing& upper, const Standing& lower, const Pose& X_LP,
                        const SightMap& sight) {
  std::size_t columns = 0, places = 0, hidden = 0, through = 0;
  for (const auto& [cell, top] : lower.top_m) {
    if (DepthIn_m(upper.hull, CenterOf(cell)) < 0) continue;
    ++columns;
    for (int k = 1; k < kPlacesPerLineOfSight; ++k, ++places) {
      const double height =
          std::lerp(top, upper.foot_m, static_cast<double>(k) / kPlacesPerLineOfSight);
      Vector3 place;
      place << CenterOf(cell), height;
      const Visibility seen =
          sight.VisibilityAt((X_LP * place).cast<float>(), static_cast<float>(upper.band_m));
      hidden += seen == Visibility::kHidden;
      through += seen == Visibility::kSeenThrough;
    }
  }
  const auto all = static_cast<double>(places);
  if (columns < kMinHidden_cells || static_cast<double>(through) > kMaxPassing * all ||
      static_cast<double>(hidden) < kMajority * all) {
    return 0;
  }
  return static_cast<double>(columns) / static_cast<double>(lower.top_m.size());
}

// Share of the upper one's footprint over the lower one.
double ShareOfFootprint(const Standing& upper, const Standing& lower) {
  double inside = 0;
  for (const auto& [cell, top] : upper.top_m) {
    inside += DepthIn_m(lower.hull, CenterOf(cell)) >= kFootprintCell_m;
  }
  return inside / static_cast<double>(upper.top_m.size());
}

// The larger of that share and the share of the lower one's top under the upper one.
double ShareOver(const Standing& upper, const Standing& lower) {
  double under = 0, tops = 0;
  for (const auto& [cell, top] : lower.top_m) {
    if (top < upper.foot_m - 2 * upper.band_m) continue;
    ++tops;
    under += DepthIn_m(upper.hull, CenterOf(cell)) >= -kFootprintCell_m;
  }
  const double under_share = tops >= kMinTop_cells ? under / tops : 0;
  return std::max(ShareOfFootprint(upper, lower), under_share);
}

// The object on the same support that the upper one rests on; null if there is none. It covers that
// one more than any other, with the larger part of its footprint, or it would tip.
const Standing* Under(const Standing& upper, const std::vector<Standing>& standing,
                      const Pose& X_LP, const SightMap* sight) {
  if (upper.foot_m <= upper.band_m) return nullptr;
  const Standing* best = nullptr;
  double max_share = upper.is_hanging ? 0 : kMajority;
  for (const Standing& lower : standing) {
    if (lower.foot_m + upper.band_m >= upper.foot_m) continue;
    double share = 0;
    if (Touches(upper, lower) || EndsBelow(upper, lower)) {
      share = ShareOver(upper, lower);
    } else if (upper.is_hanging && sight) {
      share = ShareHiddenBelow(upper, lower, X_LP, *sight);
    }
    if (share <= max_share) continue;
    max_share = share;
    best = &lower;
  }
  return best;
}

// The height in metres of the face that the upper one rests on: the median height of the lower
// one's level nodes beside the foot, within the distance of contact. The foot itself would be too
// high, as the lower one has most nodes of the crease between them. It is used where there is no
// such face, as on rims and round objects.
double ContactHeight_m(const Standing& upper, const Standing& lower, const OrientedPoints& nodes,
                       const std::vector<Segment>& segments, const Pose& X_PL) {
  // An object that leans on the other or stands behind it touches it neither with foot nor face.
  if (ShareOfFootprint(upper, lower) < kMajority) return upper.foot_m;
  const std::vector<std::uint32_t>& below = segments[lower.segment].nodes;
  const Eigen::Vector3f up = X_PL.linear().row(2).transpose().cast<float>();
  const double level_cos = std::cos(kSameNormal_rad);
  std::vector<double> heights;
  for (std::size_t k = 0; k < below.size(); k += below.size() / kMaxTestedNodes + 1) {
    const std::uint32_t i = below[k];
    if (nodes.normals[i].dot(up) < level_cos) continue;
    const Vector3 place = X_PL * nodes.points[i].cast<double>();
    if (place.z() < upper.foot_m - kFootHeight_m - upper.band_m) continue;
    if (place.z() > upper.foot_m) continue;
    if (DepthIn_m(upper.hull, place.head<2>()) >= -kMaxTouchingGap_m) heights.push_back(place.z());
  }
  if (heights.size() < kTwoSamples) return upper.foot_m;
  return Quantile(std::move(heights), 0.5);
}

// Per support, the objects on it.
std::vector<std::vector<Standing>> OnSupports(const OrientedPoints& nodes,
                                              const std::vector<Placed<Plate>>& plates,
                                              const std::vector<Segment>& segments,
                                              const Work& work) {
  std::vector<std::optional<Standing>> standing(segments.size());
  ParallelFor(segments.size(), 1, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (segments[k].supported_by < 0 || segments[k].nodes.empty()) continue;
      const auto s = static_cast<std::size_t>(segments[k].supported_by);
      standing[k].emplace(k, segments[k], nodes, plates[s].X_FS.inverse(Eigen::Isometry));
    }
  });
  std::vector<std::vector<Standing>> on_support(plates.size());
  for (std::size_t k = 0; k < segments.size(); ++k) {
    if (!standing[k]) continue;
    on_support[static_cast<std::size_t>(segments[k].supported_by)].push_back(
        *std::move(standing[k]));
  }
  return on_support;
}

}  // namespace

void AssignSupportsUnderStacks(const OrientedPoints& nodes,
                               const std::vector<Placed<Plate>>& plates, const SightMap* sight,
                               const std::vector<Segment>& objects, std::vector<Segment>& hanging,
                               const Work& work) {
  std::vector<std::vector<Standing>> on_support = OnSupports(nodes, plates, objects, work);
  for (Segment& region : hanging) region.is_hanging = true;
  // Per support, the hanging regions in its frame, computed when first needed.
  std::vector<std::vector<std::optional<Standing>>> over(plates.size());
  for (bool grown = true; grown;) {
    grown = false;
    for (std::size_t s = 0; s < plates.size(); ++s) {
      over[s].resize(hanging.size());
      for (std::size_t r = 0; r < hanging.size() && !on_support[s].empty(); ++r) {
        if (hanging[r].supported_by >= 0 || hanging[r].nodes.empty()) continue;
        std::optional<Standing>& upper = over[s][r];
        if (!upper) {
          upper.emplace(objects.size() + r, hanging[r], nodes,
                        plates[s].X_FS.inverse(Eigen::Isometry));
        }
        if (!Under(*upper, on_support[s], plates[s].X_FS, sight)) continue;
        hanging[r].supported_by = static_cast<std::int32_t>(s);
        on_support[s].push_back(*std::exchange(upper, std::nullopt));
        grown = true;
      }
    }
  }
}

void AssignResting(const OrientedPoints& nodes, const std::vector<Placed<Plate>>& plates,
                   const SightMap* sight, std::vector<Segment>& segments, const Work& work) {
  for (const std::vector<Standing>& standing : OnSupports(nodes, plates, segments, work)) {
    for (const Standing& upper : standing) {
      const Pose& X_LP =
          plates[static_cast<std::size_t>(segments[upper.segment].supported_by)].X_FS;
      const Standing* under = Under(upper, standing, X_LP, sight);
      if (!under) continue;
      segments[upper.segment].rests_on = static_cast<std::int32_t>(under->segment);
      const Pose X_PL = X_LP.inverse(Eigen::Isometry);
      segments[upper.segment].foot_height_m = ContactHeight_m(upper, *under, nodes, segments, X_PL);
    }
  }
}

}  // namespace cwm::perception
