#include "perception/segmentation/thin_things.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "perception/cloud/parallel_for.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/segmentation/height_map.h"

namespace cwm::perception {
namespace {

// chosen: things are higher than their mean's error by this factor; bumps of warp are told by their
// slopes.
constexpr double kSignificant_errors = 2;
// chosen: half the height of a thing is this many standard deviations of the smoothed heights, so
// that noise leaves its outline whole.
constexpr double kCut_sigma = 4;
// chosen: and its mean height this many of the mean's noise. A table has some thousand windows, and
// noise must not lift one of a hundred tables.
constexpr double kHeight_sigma = 8;
// chosen: the step along the outline is this many standard deviations of its noise.
constexpr double kStep_sigma = 4;
// derived: the warp's shortest waves, of length L = 0.2 m, lose at half of their height 6.5 d / L
// of their mean height over a distance d. A thing loses more, by this share.
constexpr double kShortestWarp_m = 0.2;
constexpr double kWarpSlope = 6.5, kMaxOfWarp = 0.65, kBeyondWarp = 0.2;
// chosen: no warp is as high as this many of its standard deviations; what is ends in a step of
// half its height, for smoothing rounds its corners.
constexpr double kMaxWarp_sigma = 5;
constexpr double kMinStepShare = 0.5;
// chosen: of that step, on each side that shows the support; and the share of such sides.
constexpr double kMinSideShare = 0.4;
constexpr double kMinSides = 0.8;
constexpr int kSideCount = 8;
constexpr int kMinShownSides = 4;
// chosen: heights are averaged over half a finger's width and more, as noise requires.
constexpr std::array<double, 6> kReaches_m = {0.008, 0.016, 0.024, 0.032, 0.048, 0.064};
// The cells on each side of an outline whose heights are compared, by their distance from the other
// side. The first ones have points of both sides.
constexpr int kFirstRing = 2, kLastRing = 3;
// chosen: the thresholds at which patches are searched, each three quarters of the one before. A
// patch is cut at about half of its height.
constexpr double kHighest_m = 0.030, kLowest_m = 0.0015;
constexpr double kNextThreshold = 0.75;
constexpr double kMinCut = 0.3, kMaxCut = 0.7;
// chosen: the walls of trays and boxes are higher than this above their floor.
constexpr double kWallHeight_m = 0.02;
// chosen: a larger part of a support is its surface.
constexpr double kMaxShare = 0.5;
// chosen: independent samples of the least patch.
constexpr double kMinSamples = 10;

// A connected set of cells above a threshold.
using CellList = std::vector<std::size_t>;

// The cells of a patch in a rectangle around it.
class PatchMask {
 public:
  PatchMask(const HeightMap& map, const CellList& patch, int margin) {
    range_ = {map.width(), 0, map.height(), 0};
    for (std::size_t i : patch) {
      range_.begin_u = std::min(range_.begin_u, map.u(i));
      range_.end_u = std::max(range_.end_u, map.u(i) + 1);
      range_.begin_v = std::min(range_.begin_v, map.v(i));
      range_.end_v = std::max(range_.end_v, map.v(i) + 1);
    }
    range_ = {std::max(0, range_.begin_u - margin), std::min(map.width(), range_.end_u + margin),
              std::max(0, range_.begin_v - margin), std::min(map.height(), range_.end_v + margin)};
    inside_.assign(static_cast<std::size_t>(width()) * static_cast<std::size_t>(height()), 0);
    for (std::size_t i : patch) inside_[PlaceOf(map.u(i), map.v(i))] = 1;
  }

  const CellRange& range() const { return range_; }
  int width() const { return range_.end_u - range_.begin_u; }
  int height() const { return range_.end_v - range_.begin_v; }
  std::size_t PlaceOf(int u, int v) const {
    return static_cast<std::size_t>(v - range_.begin_v) * static_cast<std::size_t>(width()) +
           static_cast<std::size_t>(u - range_.begin_u);
  }
  std::size_t IndexOf(std::size_t place, const HeightMap& map) const {
    return map.IndexAt(range_.begin_u + static_cast<int>(place) % width(),
                       range_.begin_v + static_cast<int>(place) / width());
  }
  bool IsInside(std::size_t place) const { return inside_[place] != 0; }

  // Per cell of the range, its distance in cells (of the square norm, up to `limit`) to the nearest
  // cell that `is_target`.
  template <class IsTarget>
  std::vector<int> DistancesTo(const IsTarget& is_target, int limit) const {
    std::vector<int> distance(inside_.size(), limit + 1);
    std::vector<std::size_t> front, next;
    for (std::size_t p = 0; p < inside_.size(); ++p) {
      if (is_target(p)) distance[p] = 0, front.push_back(p);
    }
    for (int step = 1; step <= limit && !front.empty(); ++step, front.swap(next)) {
      next.clear();
      for (std::size_t p : front) {
        const int u = static_cast<int>(p) % width(), v = static_cast<int>(p) / width();
        for (int dv = -1; dv <= 1; ++dv) {
          for (int du = -1; du <= 1; ++du) {
            if (u + du < 0 || u + du >= width() || v + dv < 0 || v + dv >= height()) continue;
            const std::size_t other =
                p + static_cast<std::size_t>(static_cast<std::ptrdiff_t>(dv) * width() + du);
            if (distance[other] <= limit) continue;
            distance[other] = step;
            next.push_back(other);
          }
        }
      }
    }
    return distance;
  }

 private:
  CellRange range_;
  std::vector<char> inside_;
};

// The mean of heights and its error.
struct MeanHeight {
  double points = 0, sum_m = 0, variance_m2 = 0;

  void Add(const HeightMap::Cell& cell, double level_m) {
    points += cell.points;
    sum_m += cell.sum_m - cell.points * level_m;
    variance_m2 += cell.variance_m2;
  }
  double mean_m() const { return points > 0 ? sum_m / points : 0; }
  // The variance of the mean; of `per_sample` neighbours one error is independent.
  double ErrorOfMean_m2(double per_sample) const {
    return points > 0 ? variance_m2 / points * per_sample / points : 0;
  }
};

// The search for patches on heights that are smoothed over one reach.
class ThinSearch {
 public:
  ThinSearch(const HeightMap& map, const std::vector<float>& level, double reach_m,
             double per_sample, double warp_m, const std::vector<float>& others_m,
             std::vector<char>& taken)
      : map_(map),
        per_sample_(per_sample),
        warp_m_(warp_m),
        reach_(map.CellsIn(reach_m)),
        level_(level),
        raised_(map.Smoothed(reach_, per_sample)),
        others_m_(others_m),
        taken_(taken) {
    std::vector<float> heights_m, sigmas_m;
    const std::size_t stride = SampleStride(map_.size());
    for (std::size_t i = 0; i < map_.size(); ++i) {
      raised_.height_m[i] -= level_[i];
      if (!map_.At(i).has_data()) continue;
      if (data_++ % stride != 0) continue;
      heights_m.push_back(raised_.height_m[i]);
      sigmas_m.push_back(raised_.sigma_m[i]);
    }
    per_sample_ *= CorrelationOf(heights_m, Median(std::move(sigmas_m)));
    raised_.sigma_scale = static_cast<float>(std::sqrt(per_sample_ / per_sample));
  }

  void Find(const Work& work, std::vector<CellList>& found) {
    for (double cut_m = kHighest_m; cut_m >= kLowest_m; cut_m *= kNextThreshold) {
      work.Poll();
      for (const CellList& patch : PatchesAbove(cut_m)) {
        std::optional<CellList> thing = ThingIn(patch, cut_m);
        if (!thing) continue;
        for (std::size_t i : *thing) taken_[i] = 1;
        found.push_back(*std::move(thing));
      }
    }
  }

 private:
  // How much larger the variance of the smoothed heights is than their noise and warp: matching of
  // windows, for one, correlates the errors of more neighbours. At least 1. Things only raise
  // heights, so that the lower ones tell the spread of the surface.
  double CorrelationOf(const std::vector<float>& heights_m, float sigma_m) const {
    constexpr double kUpper = 0.3, kLower = 0.05;  // quantiles
    constexpr double kSigmasBetween = 1.12;        // of a normal distribution
    const double shown_m =
        double{Quantile(heights_m, kUpper) - Quantile(heights_m, kLower)} / kSigmasBetween;
    const double noise_m2 = shown_m * shown_m - warp_m_ * warp_m_;
    return std::max(1.0, noise_m2 / std::max(1e-12, double{sigma_m} * double{sigma_m}));
  }

  bool IsAbove(std::size_t i, double cut_m) const {
    return map_.At(i).has_data() && taken_[i] == 0 && raised_.height_m[i] > cut_m;
  }

  // The cells above the cut that are connected with the first one, which are marked in `seen`.
  CellList Flood(std::size_t first, double cut_m, std::vector<char>& seen) const {
    CellList patch = {first};
    seen[first] = 1;
    for (std::size_t k = 0; k < patch.size(); ++k) {
      const int u = map_.u(patch[k]), v = map_.v(patch[k]);
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) {
          if (u + du < 0 || u + du >= map_.width() || v + dv < 0 || v + dv >= map_.height()) {
            continue;
          }
          const std::size_t other = map_.IndexAt(u + du, v + dv);
          if (seen[other] != 0 || !IsAbove(other, cut_m)) continue;
          seen[other] = 1;
          patch.push_back(other);
        }
      }
    }
    return patch;
  }

  bool MayBeThing(const CellList& patch, double cut_m) const {
    double points = 0, sum_sigma_m = 0;
    for (std::size_t i : patch) {
      points += map_.At(i).points;
      sum_sigma_m += raised_.sigma_scale * raised_.sigma_m[i];
    }
    const auto cells = static_cast<double>(patch.size());
    return points >= kMinSamples * per_sample_ && cells <= kMaxShare * static_cast<double>(data_) &&
           cut_m >= kCut_sigma * sum_sigma_m / cells;
  }

  std::vector<CellList> PatchesAbove(double cut_m) const {
    std::vector<char> seen(map_.size(), 0);
    std::vector<CellList> patches;
    for (std::size_t i = 0; i < map_.size(); ++i) {
      if (seen[i] != 0 || !IsAbove(i, cut_m)) continue;
      CellList patch = Flood(i, cut_m, seen);
      if (MayBeThing(patch, kMaxCut * cut_m)) patches.push_back(std::move(patch));
    }
    return patches;
  }

  // The thing that the patch is a part of, cut at half of its height; empty if it is none.
  std::optional<CellList> ThingIn(const CellList& patch, double cut_m) const {
    const std::optional<double> height_m = HeightOf(patch);
    if (!height_m || cut_m < kMinCut * *height_m || cut_m > kMaxCut * *height_m) {
      return std::nullopt;
    }
    std::vector<char> seen(map_.size(), 0);
    const std::size_t highest =
        *std::ranges::max_element(patch, {}, [&](std::size_t i) { return raised_.height_m[i]; });
    CellList thing = Flood(highest, *height_m / 2, seen);
    if (!MayBeThing(thing, *height_m / 2) || !IsThing(thing)) return std::nullopt;
    return thing;
  }

  // The mean height of the patch's inner part above the level around it; empty if it has none.
  std::optional<double> HeightOf(const CellList& patch) const {
    const PatchMask mask(map_, patch, 1);
    const std::vector<int> to_outside = DistancesToOutside(mask, reach_ + 1);
    MeanHeight inner;
    for (std::size_t i : patch) {
      if (to_outside[mask.PlaceOf(map_.u(i), map_.v(i))] > reach_) {
        inner.Add(map_.At(i), level_[i]);
      }
    }
    if (inner.points < per_sample_) return std::nullopt;
    return inner.mean_m();
  }

  // To the nearest cells beside the patch that show anything.
  std::vector<int> DistancesToOutside(const PatchMask& mask, int limit) const {
    const auto is_outside = [&](std::size_t p) {
      return !mask.IsInside(p) && map_.At(mask.IndexOf(p, map_)).has_data();
    };
    return mask.DistancesTo(is_outside, limit);
  }

  struct Sides {
    std::array<MeanHeight, kSideCount> in, out;
  };

  // The heights on both sides of the patch's outline, by direction.
  Sides SidesOf(const CellList& patch) const {
    const PatchMask mask(map_, patch, kLastRing);
    const std::vector<int> to_outside = DistancesToOutside(mask, kLastRing);
    const std::vector<int> to_patch =
        mask.DistancesTo([&](std::size_t p) { return mask.IsInside(p); }, kLastRing);
    Vector2 middle = Vector2::Zero();
    for (std::size_t i : patch) middle += Vector2(map_.u(i), map_.v(i));
    middle /= static_cast<double>(patch.size());
    Sides sides;
    for (int v = mask.range().begin_v; v < mask.range().end_v; ++v) {
      for (int u = mask.range().begin_u; u < mask.range().end_u; ++u) {
        const std::size_t i = map_.IndexAt(u, v);
        if (!map_.At(i).has_data() || taken_[i] != 0) continue;
        const std::size_t p = mask.PlaceOf(u, v);
        const int distance = mask.IsInside(p) ? to_outside[p] : to_patch[p];
        if (distance < kFirstRing || distance > kLastRing) continue;
        const double angle_rad = std::atan2(v - middle.y(), u - middle.x()) + std::numbers::pi;
        const auto side =
            static_cast<std::size_t>(angle_rad / (2 * std::numbers::pi) * kSideCount) % kSideCount;
        (mask.IsInside(p) ? sides.in : sides.out)[side].Add(map_.At(i), 0);
      }
    }
    return sides;
  }

  // The variance of the difference of the warps at two places this far apart.
  double WarpBetween_m2(double distance_m) const {
    const double apart = distance_m / kWarpCorrelation_m;
    return 2 * warp_m_ * warp_m_ * (1 - std::exp(-apart * apart / 2));
  }

  bool IsThing(const CellList& patch) const {
    const std::optional<double> height_m = HeightOf(patch);
    if (!height_m) return false;
    MeanHeight whole;
    for (std::size_t i : patch) whole.Add(map_.At(i), level_[i]);
    const double error_m = std::sqrt(whole.ErrorOfMean_m2(per_sample_) + warp_m_ * warp_m_);
    if (*height_m < kSignificant_errors * error_m) return false;
    if (*height_m < kHeight_sigma * std::sqrt(whole.ErrorOfMean_m2(per_sample_))) return false;

    const Sides sides = SidesOf(patch);
    MeanHeight in, out;
    for (int side = 0; side < kSideCount; ++side) {
      const auto k = static_cast<std::size_t>(side);
      if (sides.in[k].points == 0 || sides.out[k].points == 0) continue;
      in.points += sides.in[k].points, in.sum_m += sides.in[k].sum_m;
      in.variance_m2 += sides.in[k].variance_m2;
      out.points += sides.out[k].points, out.sum_m += sides.out[k].sum_m;
      out.variance_m2 += sides.out[k].variance_m2;
    }
    if (in.points == 0 || out.points == 0) return false;
    const double step_m = in.mean_m() - out.mean_m();
    const double across_m = (kFirstRing + kLastRing - 1) * map_.edge_m();
    const double step_error_m =
        std::sqrt(in.ErrorOfMean_m2(per_sample_) + out.ErrorOfMean_m2(per_sample_) +
                  WarpBetween_m2(across_m) / kMinShownSides);
    const double of_warp = std::min(kMaxOfWarp, kWarpSlope * across_m / kShortestWarp_m);
    if (step_m < kStep_sigma * step_error_m) return false;
    const bool may_be_warp = *height_m < kMaxWarp_sigma * warp_m_;
    const double min_share = may_be_warp ? of_warp + kBeyondWarp : kMinStepShare;
    if (step_m < min_share * *height_m) return false;
    return IsStepAround(sides, step_m) && !IsWalled(patch, *height_m);
  }

  // True if more of the outline lies along higher pieces than along the support: the patch is the
  // floor of something.
  bool IsWalled(const CellList& patch, double height_m) const {
    const PatchMask mask(map_, patch, kLastRing);
    const std::vector<int> to_patch =
        mask.DistancesTo([&](std::size_t p) { return mask.IsInside(p); }, kLastRing);
    int walls = 0, open = 0;
    for (std::size_t p = 0; p < to_patch.size(); ++p) {
      if (to_patch[p] < 1 || to_patch[p] > kFirstRing) continue;
      const std::size_t i = mask.IndexOf(p, map_);
      const bool is_wall = others_m_[i] > height_m + kWallHeight_m;
      walls += is_wall;
      open += !is_wall && map_.At(i).has_data();
    }
    return walls > open;
  }

  bool IsStepAround(const Sides& sides, double step_m) const {
    int shown = 0, stepped = 0;
    for (std::size_t k = 0; k < kSideCount; ++k) {
      const MeanHeight &in = sides.in[k], &out = sides.out[k];
      if (in.points < per_sample_ || out.points < per_sample_) continue;
      ++shown;
      const double error_m =
          std::sqrt(in.ErrorOfMean_m2(per_sample_) + out.ErrorOfMean_m2(per_sample_));
      stepped += in.mean_m() - out.mean_m() >= kMinSideShare * step_m - error_m;
    }
    return shown >= kMinShownSides && stepped >= kMinSides * shown;
  }

  const HeightMap& map_;
  double per_sample_;  // points whose errors are alike
  const double warp_m_;
  const int reach_;  // cells
  const std::vector<float>& level_;
  HeightMap::MeanHeights raised_;       // smoothed heights above the level
  const std::vector<float>& others_m_;  // the highest point of other pieces over each cell
  std::vector<char>& taken_;
  std::size_t data_ = 0;  // cells with data
};

// Fine patches first: wider windows blur the outlines of small things.
std::vector<CellList> FindThings(const HeightMap& map, const Plane& plane,
                                 const OrientedPoints& nodes, const Pieces& pieces,
                                 const Work& work) {
  const std::vector<float> level = map.Level();
  std::vector<float> others_m(map.size(), 0.0F);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (pieces.of_node[i] < pieces.support_count) continue;
    if (const auto cell = map.CellUnder(nodes.points[i])) {
      const auto height_m = static_cast<float>(plane.Height_m(nodes.points[i]));
      others_m[*cell] = std::max(others_m[*cell], height_m);
    }
  }
  std::vector<char> taken(map.size(), 0);
  std::vector<CellList> found;
  for (const double reach_m : kReaches_m) {
    ThinSearch(map, level, reach_m, double{nodes.points_per_sample}, double{nodes.warp_m}, others_m,
               taken)
        .Find(work, found);
  }
  return found;
}

}  // namespace

void SeparateThinThings(const SurfaceGraph& graph, const std::vector<SupportPlane>& supports,
                        Pieces& pieces, const Work& work) {
  const auto count = static_cast<std::size_t>(pieces.support_count);
  std::vector<std::vector<std::uint32_t>> nodes(count);
  for (std::uint32_t i = 0; i < graph.size(); ++i) {
    const std::int32_t p = pieces.of_node[i];
    if (p >= 0 && p < pieces.support_count) nodes[static_cast<std::size_t>(p)].push_back(i);
  }
  // Per support, the cells of things as places in the list of its nodes.
  std::vector<std::vector<std::vector<std::uint32_t>>> things(count);
  ParallelFor(count, 1, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      if (nodes[s].empty()) continue;
      const HeightMap map(graph, supports[s].plane, nodes[s]);
      const std::vector<CellList> found =
          FindThings(map, supports[s].plane, graph.nodes(), pieces, work);
      if (found.empty()) continue;
      std::vector<std::int32_t> thing_of_cell(map.size(), kNoIndex);
      for (std::size_t t = 0; t < found.size(); ++t) {
        for (std::size_t i : found[t]) thing_of_cell[i] = static_cast<std::int32_t>(t);
      }
      things[s].resize(found.size());
      for (std::size_t k = 0; k < nodes[s].size(); ++k) {
        const std::int32_t t = thing_of_cell[map.CellOfNode(k)];
        if (t != kNoIndex) things[s][static_cast<std::size_t>(t)].push_back(nodes[s][k]);
      }
    }
  });
  for (const auto& of_support : things) {
    for (const std::vector<std::uint32_t>& thing : of_support) {
      for (std::uint32_t i : thing) pieces.of_node[i] = pieces.piece_count;
      ++pieces.piece_count;
    }
  }
}

}  // namespace cwm::perception
