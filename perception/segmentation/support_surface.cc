#include "perception/segmentation/support_surface.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

// A region is over the support if the larger part of its nodes lies within kMaxTouchingGap_m of the
// outline: objects may jut out, the outline is accurate to one cell of 7.5 mm or more, and an
// object that juts out by more than half would tip. A region that leaves the view, or whose shadow
// cuts the support off, has fewer nodes over the visible part of the support, but more than mixed
// pixels are (kMaxPassing). Nodes below the support's top, beyond that share, belong to something
// beside it.

// derived: a ball seen from above shows nothing of its underside: the tangent rays leave it at 0.3
// of its radius, its grazing rim returns nothing up to 0.6, and the lowest tenth of what is seen
// reaches to 0.8, which is about this share of the width that is seen.
constexpr double kHiddenUndersideShare = 0.45;
// chosen: no object wider than this that rolls is manipulated.
constexpr double kWidestRound_m = 0.12;
// chosen: the largest width of a cell of the support in cells of a footprint. Where noise makes
// cells wider, far away or in a scene of another scale, footprints are coarser too.
constexpr double kMaxReach_cells = 6;

}  // namespace

SupportSurface::SupportSurface(const SurfaceGraph& graph, const CoarseCloud& coarse,
                               const SupportPlane& support, const Placed<Plate>& plate,
                               const SightMap& sight)
    : graph_(graph),
      plate_(plate),
      sight_(sight),
      X_SL_(plate.X_FS.inverse(Eigen::Isometry)),
      cell_m_(std::max(kFootprintCell_m, coarse.grid.edge_m() / kMaxReach_cells)) {
  for (std::uint32_t c : support.cells) occupied_.insert(CellOf(Local(coarse.cells.points[c])));
  reach_ = static_cast<int>(std::ceil(coarse.grid.edge_m() / cell_m_));
  for (const FootprintCell& cell : occupied_) extent_.extend(MiddleOf(cell));
}

SupportSurface::FootprintCell SupportSurface::CellOf(const Vector3& local) const {
  return {static_cast<int>(std::floor(local.x() / cell_m_)),
          static_cast<int>(std::floor(local.y() / cell_m_))};
}

Vector2 SupportSurface::MiddleOf(const FootprintCell& cell) const {
  return {(cell.first + 0.5) * cell_m_, (cell.second + 0.5) * cell_m_};
}

bool SupportSurface::Carries(const NodeList& region) const {
  if (region.empty()) return false;
  const NodeList over = NodesOver(region);
  const auto all = static_cast<double>(region.size()), share = static_cast<double>(over.size());
  if (share < kMajority * all) {
    if (share >= kMaxPassing * all && HidesItsPlace(region)) {
      return StandsOrIsHidden(region) && Footprint_m2(over) >= kMinObjectArea_m2;
    }
    if (IsOverHiddenPart(region)) {
      return StandsOrIsHidden(region) && Footprint_m2(region) >= kMinObjectArea_m2;
    }
    return share >= kMaxPassing * all && HidesItsSupport(region) &&
           Footprint_m2(over) >= kMinObjectArea_m2;
  }
  return (StandsOrIsHidden(over) || IsBallOnIt(over)) && Footprint_m2(over) >= kMinObjectArea_m2;
}

SupportSurface::NodeList SupportSurface::NodesOver(const NodeList& region) const {
  NodeList over;
  std::map<FootprintCell, bool> inside;  // per cell, so that the outline is tested once
  auto latest = inside.end();            // consecutive nodes are mostly in one cell
  for (std::uint32_t i : region) {
    const Vector3 local = Local(graph_.nodes().points[i]);
    if (local.z() < -kGate_sigma * graph_.nodes().sigma_m[i]) continue;
    if (const FootprintCell cell = CellOf(local); latest == inside.end() || latest->first != cell) {
      bool is_new;
      std::tie(latest, is_new) = inside.try_emplace(cell, false);
      if (is_new) {
        latest->second =
            OutsideOutline_m(plate_, graph_.nodes().points[i].cast<double>()) <= kMaxTouchingGap_m;
      }
    }
    if (latest->second) over.push_back(i);
  }
  return over;
}

// True if the support below the region is mostly hidden or out of the view, a part of it out of the
// view, and hardly any of the region is lower than the support.
bool SupportSurface::HidesItsPlace(const NodeList& region) const {
  std::size_t below = 0, hidden = 0, in_view = 0, asked = 0;
  for (std::size_t k = 0; k < region.size(); k += region.size() / kMaxSamples + 1, ++asked) {
    const float sigma = graph_.nodes().sigma_m[region[k]];
    Vector3 local = Local(graph_.nodes().points[region[k]]);
    below += local.z() < -kGate_sigma * sigma;
    local.z() = 0.5 * kFootHeight_m;
    const Visibility seen =
        sight_.VisibilityAt((plate_.X_FS * local).cast<float>(), MaxJump_m(sigma));
    hidden += seen == Visibility::kHidden;
    in_view += seen != Visibility::kNoReturn;
  }
  const auto all = static_cast<double>(asked);
  return static_cast<double>(below) <= kMaxPassing * all &&
         static_cast<double>(in_view) <= kNearlyAll * all &&
         static_cast<double>(hidden + asked - in_view) >= kMajority * all;
}

// True if the support may continue below the region although only a part beside it was seen, like a
// low table behind a counter: hardly any of the region is lower, something hides the places before
// its foot (farther away than contact, so it is not its own shadow), and all places between its
// foot and the visible part of the support are hidden too.
bool SupportSurface::IsOverHiddenPart(const NodeList& region) const {
  const Vector2 sensor = Local(sight_.viewpoint()).head<2>();
  std::vector<std::pair<Vector2, float>> feet;  // with the tolerance in range of each foot
  std::size_t below = 0, before = 0;
  for (std::size_t k = 0; k < region.size(); k += region.size() / kLinesOfSight + 1) {
    const float sigma = graph_.nodes().sigma_m[region[k]], jump_m = MaxJump_m(sigma);
    const Vector3 local = Local(graph_.nodes().points[region[k]]);
    const Vector2 foot = local.head<2>();
    if (extent_.exteriorDistance(foot) > kMaxHiddenGap_m) return false;
    below += local.z() < -kGate_sigma * sigma;
    before += VisibilityAbove(foot + kMaxTouchingGap_m * (sensor - foot).normalized(), jump_m) ==
              Visibility::kHidden;
    feet.emplace_back(foot, jump_m);
  }
  const auto all = static_cast<double>(feet.size());
  if (static_cast<double>(below) > kMaxPassing * all) return false;
  if (static_cast<double>(before) < kMainShare * all) return false;
  const auto closed = std::ranges::count_if(
      feet, [&](const auto& foot) { return IsHiddenToSupport(foot.first, foot.second); });
  return static_cast<double>(closed) >= kMainShare * all;
}

// True if the region hides the unseen part of the support, as at an edge that its own shadow cuts
// off: hardly any of the region is lower, and no ray passes right below its foot, as it does below
// something that hangs beside the support.
bool SupportSurface::HidesItsSupport(const NodeList& region) const {
  NodeList feet;
  std::size_t below = 0;
  for (std::uint32_t i : region) {
    const double height_m = Local(graph_.nodes().points[i]).z();
    const double gate_m = kGate_sigma * graph_.nodes().sigma_m[i];
    below += height_m < -gate_m;
    if (height_m <= kFootHeight_m + gate_m) feet.push_back(i);
  }
  const auto all = static_cast<double>(region.size());
  if (static_cast<double>(below) > kMaxPassing * all) return false;
  if (static_cast<double>(feet.size()) < kMaxPassing * all) return false;
  std::size_t hidden = 0, through = 0, asked = 0;
  for (std::size_t k = 0; k < feet.size(); k += feet.size() / kMaxSamples + 1, ++asked) {
    Vector3 local = Local(graph_.nodes().points[feet[k]]);
    local.z() = -kFootHeight_m;
    const Visibility seen = sight_.VisibilityAt((plate_.X_FS * local).cast<float>(),
                                                MaxJump_m(graph_.nodes().sigma_m[feet[k]]));
    hidden += seen == Visibility::kHidden;
    through += seen == Visibility::kSeenThrough;
  }
  return static_cast<double>(hidden) >= kMajority * static_cast<double>(asked) &&
         static_cast<double>(through) <= kMaxPassing * static_cast<double>(asked);
}

Visibility SupportSurface::VisibilityAbove(const Vector2& foot, float jump_m) const {
  const Vector3 place = plate_.X_FS * Vector3(foot.x(), foot.y(), 0.5 * kFootHeight_m);
  return sight_.VisibilityAt(place.cast<float>(), jump_m);
}

bool SupportSurface::IsHiddenToSupport(const Vector2& from, float jump_m) const {
  Vector2 to = from;
  double nearest_m = kMaxHiddenGap_m;
  for (const FootprintCell& cell : occupied_) {
    const double away_m = (MiddleOf(cell) - from).norm();
    if (away_m < nearest_m) nearest_m = away_m, to = MiddleOf(cell);
  }
  if (nearest_m >= kMaxHiddenGap_m) return false;
  int through = 0;  // consecutive places: a single one may be a mixed pixel
  for (double at_m = 0; at_m < nearest_m && through < 2; at_m += cell_m_) {
    const Vector2 place = from + at_m / nearest_m * (to - from);
    through = VisibilityAbove(place, jump_m) == Visibility::kSeenThrough ? through + 1 : 0;
  }
  return through < 2;
}

// True if nearly all nodes lie on one sphere that touches the support. From steeply above a ball
// shows no foot. The sphere is the algebraic fit |p|^2 = 2 c . p + k (Kasa 1976); the other nodes
// are creases and mixed pixels.
bool SupportSurface::IsBallOnIt(const NodeList& over) const {
  const std::size_t stride = over.size() / kMaxSamples + 1;
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
    on += std::abs(off_m) <= kGate_sigma * graph_.nodes().sigma_m[over[k]];
  }
  return static_cast<double>(on) >= kNearlyAll * static_cast<double>(asked) &&
         std::abs(x[2] - radius_m) <= MaxJump_m(sigma);
}

// True if enough of the lowest nodes touch the support, or if the space between them and the
// support is hidden. The lowest nodes are those with nearly all others above; enough are more than
// chance makes. A hanging object shows empty space below all of them.
bool SupportSurface::StandsOrIsHidden(const NodeList& over) const {
  std::vector<std::pair<double, std::uint32_t>> heights;
  Eigen::AlignedBox2d extent;
  for (std::uint32_t i : over) {
    const Vector3 local = Local(graph_.nodes().points[i]);
    heights.emplace_back(local.z(), i);
    extent.extend(Vector2(local.head<2>()));
  }
  const double width_m = std::min(extent.sizes().minCoeff(), kWidestRound_m);
  const double foot_m = std::max(kFootHeight_m, kHiddenUndersideShare * width_m);
  const auto low = heights.begin() + static_cast<std::ptrdiff_t>(
                                         (1 - kNearlyAll) * static_cast<double>(heights.size()));
  std::nth_element(heights.begin(), low, heights.end());
  std::size_t standing = 0, asked = 0;
  const auto count = static_cast<std::size_t>(low - heights.begin()) + 1;
  for (std::size_t k = 0; k < count;
       k += std::max<std::size_t>(1, count / kLinesOfSight), ++asked) {
    standing += StandsOrIsHidden(heights[k].second, heights[k].first, foot_m);
  }
  return static_cast<double>(standing) >= kMinSignificantShare * static_cast<double>(asked);
}

bool SupportSurface::StandsOrIsHidden(std::uint32_t node, double height, double foot_m) const {
  const float sigma = graph_.nodes().sigma_m[node];
  if (height <= foot_m + kGate_sigma * sigma) return true;
  const Vector3f up = plate_.X_FS.linear().col(2).cast<float>();
  for (const float share : {0.25f, 0.5f, 0.75f}) {
    const Vector3f below = graph_.nodes().points[node] - share * static_cast<float>(height) * up;
    if (sight_.VisibilityAt(below, MaxJump_m(sigma)) == Visibility::kSeenThrough) return false;
  }
  return true;
}

// Area of the region's projection in square metres, as far as it lies on cells of the support,
// right beside them (an object hides the support below itself) or in hidden places: an object
// behind a larger one is surrounded by that one's shadow.
double SupportSurface::Footprint_m2(const NodeList& over) const {
  std::set<FootprintCell> cells;
  auto latest = cells.end();
  for (std::uint32_t i : over) {
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

bool SupportSurface::IsHiddenAt(const FootprintCell& cell) const {
  const Vector2 middle = MiddleOf(cell);
  const Vector3 local(middle.x(), middle.y(), 0);
  return sight_.VisibilityAt((plate_.X_FS * local).cast<float>(),
                             static_cast<float>(kFootHeight_m)) == Visibility::kHidden;
}

}  // namespace cwm::perception
