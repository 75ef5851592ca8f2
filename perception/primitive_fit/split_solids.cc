#include "perception/primitive_fit/split_solids.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bitset>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "collision/geometry/polygon.h"
#include "perception/cloud/parallel_for.h"
#include "perception/cloud/tolerances.h"
#include "perception/primitive_fit/shrink_to_free_space.h"
#include "perception/primitive_fit/single_primitive.h"
#include "perception/primitive_fit/unexplained_points.h"
#include "perception/solids/free_space.h"

namespace cwm::perception {
namespace {

// chosen: the largest value of the parts relative to that of several assembled solids, and to that
// of one solid for all points: the slow warp of sensors bends a face more than the criterion
// expects. With 0.8 and 0.6 more simulated objects that touch stayed one; labelled Kinect scans are
// split alike with both.
constexpr double kMaxValueRatioToSeveral = 0.95, kMaxValueRatioToOne = 0.85;

using Members = std::vector<std::uint32_t>;

// chosen: the share of a solid's points that noise leaves beyond their gates.
constexpr double kMaxBeyondGates = 0.01;
// derived: bounds the work. Each part is cut off once, and both sides of a cut are fitted.
constexpr std::size_t kMaxFits = kMaxParts * 2;
// chosen: the cuts that are tried are 15 degrees and a sixteenth of the extent apart. Points of a
// part on the wrong side of a cut join it once its solid is known.
constexpr int kCutYaws = 12, kCutOffsets = 15;
// chosen: in measured points; smaller parts are meshed.
constexpr double kMinPart = 150;
// chosen: bounds the work: cuts that are tried for a part, each with one neighbour.
constexpr std::size_t kMaxCuts = 4;
// chosen: the largest volume of both sides, relative to that of the uncut points. Objects side by
// side leave gaps or differ in height.
constexpr double kMaxVolumeRatio = 0.97;

struct Cut {
  Vector2 normal = Vector2::UnitX();
  double offset_m = 0;
  double volume_ratio = 1;  // volume of both sides, relative to the uncut one's
  std::bitset<kUsedPoints> side;

  // The share of the points that are on the other side of the other cut, whichever way its normal
  // points.
  double DifferingShare(const Cut& other, std::size_t points) const {
    const std::size_t differ = (side ^ other.side).count();
    return static_cast<double>(std::min(differ, points - differ)) / static_cast<double>(points);
  }
};

// A cut and the best of its neighbours: their volumes may differ by noise alone.
struct Candidate {
  Cut cut;
  std::optional<Cut> neighbour;
};

double HullArea_m2(std::vector<Vector2> points) {
  const Polygon hull = ConvexHull(std::move(points));
  return hull.size() < 3 ? 0 : SignedArea_m2(hull);
}

// The volume below the points: the area of their hull from above times the height of the highest of
// them. Each point holds its place in the plan and its height.
double VolumeBelow_m3(const std::vector<Vector3>& points) {
  std::vector<Vector2> from_above;
  double top_m = 0;
  for (const Vector3& p : points) {
    from_above.emplace_back(p.head<2>());
    top_m = std::max(top_m, p.z());
  }
  return HullArea_m2(std::move(from_above)) * top_m;
}

// Coordinates in the plane of the ground, seen from above.
class GroundPlan {
 public:
  explicit GroundPlan(const FitContext& c) : c_(c), level_(BasisFromZ(c.ground.up).leftCols<2>()) {}
  Vector2 At(std::uint32_t i) const { return level_.transpose() * c_.points.p[i]; }
  // The place of a point in the plan, and its height above the ground.
  Vector3 WithHeight(std::uint32_t i) const {
    const Vector2 at = At(i);
    return {at.x(), at.y(), c_.ground.up.dot(c_.points.p[i] - c_.ground.point)};
  }

 private:
  const FitContext& c_;
  const Eigen::Matrix<double, 3, 2> level_;
};

// The cuts with the least volume, each different from the ones before.
std::vector<Candidate> CutsOf(const Members& part, const GroundPlan& plan) {
  std::vector<Vector3> points;
  for (std::uint32_t i : Subsampled(part, kUsedPoints)) points.push_back(plan.WithHeight(i));
  const double all_m3 = VolumeBelow_m3(points);
  const auto min_points = std::max<std::size_t>(
      3, static_cast<std::size_t>(kMinPiece * static_cast<double>(points.size())));
  std::vector<Cut> cuts;
  if (!(all_m3 > 0)) return {};
  for (int k = 0; k < kCutYaws; ++k) {
    const double yaw_rad = k * std::numbers::pi / kCutYaws;
    Cut cut{.normal = Vector2(std::cos(yaw_rad), std::sin(yaw_rad)), .side = {}};
    double low_m = std::numeric_limits<double>::infinity(), high_m = -low_m;
    const auto across_m = [&](const Vector3& p) { return cut.normal.dot(p.head<2>()); };
    for (const Vector3& p : points) {
      low_m = std::min(low_m, across_m(p)), high_m = std::max(high_m, across_m(p));
    }
    for (int j = 1; j <= kCutOffsets; ++j) {
      cut.offset_m = low_m + (high_m - low_m) * j / (kCutOffsets + 1);
      std::vector<Vector3> below, above;
      cut.side.reset();
      for (std::size_t i = 0; i < points.size(); ++i) {
        const bool is_above = across_m(points[i]) > cut.offset_m;
        (is_above ? above : below).push_back(points[i]);
        cut.side[i] = is_above;
      }
      if (std::min(below.size(), above.size()) < min_points) continue;
      cut.volume_ratio = (VolumeBelow_m3(below) + VolumeBelow_m3(above)) / all_m3;
      if (cut.volume_ratio <= kMaxVolumeRatio) cuts.push_back(cut);
    }
  }
  std::stable_sort(cuts.begin(), cuts.end(),
                   [](const Cut& a, const Cut& b) { return a.volume_ratio < b.volume_ratio; });
  std::vector<Candidate> best;
  for (const Cut& cut : cuts) {
    // A cut that is the same or a close neighbour has nearly all points on the same sides.
    const auto known = std::ranges::find_if(best, [&](const Candidate& candidate) {
      return candidate.cut.DifferingShare(cut, points.size()) <= 1 - kNearlyAll;
    });
    if (known == best.end()) {
      if (best.size() < kMaxCuts) best.push_back({cut, {}});
    } else if (!known->neighbour && known->cut.DifferingShare(cut, points.size()) > kMinPiece) {
      known->neighbour = cut;
    }
  }
  return best;
}

struct Part {
  Members members;
  std::optional<PrimitiveFit> fit;  // fitted to most of them; its solid has no inliers
};

// Every fourth ray, with the same weight. A cut runs beside the true border, so while parts are
// sought a solid is less to blame for the free space that it claims than in the end.
FreeRays SubsampledRays(const FreeRays& free) {
  // chosen: rays count for a quarter of what they count for in the end.
  constexpr std::size_t kRayStride = 4;
  FreeRays few{.rays = {}, .weight = free.weight};
  for (std::size_t k = 0; k < free.rays.size(); k += kRayStride) few.rays.push_back(free.rays[k]);
  return few;
}

class SolidSplitter {
 public:
  explicit SolidSplitter(const FitContext& c) : c_(c), plan_(c) {}

  // Returns parts whose solids explain nearly all points together, if there are any.
  std::optional<std::vector<Part>> Run() {
    Members open(c_.points.size());
    std::iota(open.begin(), open.end(), std::uint32_t{0});
    std::vector<Part> parts;
    while (IsLargeEnough(open)) {
      if (auto fit = parts.empty() ? std::nullopt : FitPart(open)) {
        parts.push_back({std::exchange(open, {}), std::move(fit)});
        break;
      }
      std::vector<Part> sides = BestCutSides(open);
      if (sides.empty() || parts.size() + sides.size() > kMaxParts) {
        if (parts.size() > 1 && AreFew(open)) break;  // the rest is meshed
        return std::nullopt;
      }
      if (sides.size() == 1) {
        parts.push_back(WithPointsOnSolid(std::move(sides[0]), open));
      } else {
        std::ranges::move(sides, std::back_inserter(parts));
        open.clear();
      }
    }
    return Merged(Reassigned(std::move(parts)));
  }

  Solid SolidOf(const Part& part) const {
    const ModelPoints own = Subset(c_.points, part.members);
    Solid solid = WithParameterSigmas(*part.fit, ContextFor(own, c_.free));
    for (std::uint32_t i : part.members) {
      if (IsOn(part, i)) solid.inliers.push_back(i);
    }
    return solid;
  }

 private:
  bool IsLargeEnough(const Members& members) const {
    return !AreFew(members) || static_cast<double>(members.size()) * c_.points.weight >= kMinPart;
  }
  bool AreFew(const Members& members) const {
    return static_cast<double>(members.size()) <=
           (1 - kNearlyAll) * static_cast<double>(c_.points.size());
  }

  std::array<Part, 2> SidesOf(const Cut& cut, const Members& open) {
    std::array<Part, 2> sides;
    for (std::uint32_t i : open) {
      sides[cut.normal.dot(plan_.At(i)) > cut.offset_m ? 1 : 0].members.push_back(i);
    }
    FitEach(sides);
    return sides;
  }

  // Returns both sides of the best cut that leaves each side explained by a solid. If there is no
  // such cut, returns the side with a solid that IsBetterCutOff prefers, or nothing.
  std::vector<Part> BestCutSides(const Members& open) {
    std::vector<Part> best;
    double best_value = std::numeric_limits<double>::infinity();
    const auto offer = [&](std::array<Part, 2> sides) {
      const double value = ValueOf({sides[0].fit->solid, sides[1].fit->solid}, open);
      if (!(value < best_value - kDecisive)) return;  // cuts with less volume come first
      best_value = value;
      best.clear();
      std::ranges::move(sides, std::back_inserter(best));
    };
    std::vector<Cut> neighbours;
    for (const Candidate& candidate : CutsOf(open, plan_)) {
      if (fits_ >= kMaxFits) break;
      std::array<Part, 2> sides = SidesOf(candidate.cut, open);
      if (sides[0].fit && sides[1].fit) {
        offer(std::move(sides));
        continue;
      }
      if (candidate.neighbour) neighbours.push_back(*candidate.neighbour);
      if (best.size() == 2) continue;
      for (Part& side : sides) {
        if (!side.fit) continue;
        if (best.empty() || IsBetterCutOff(side, best[0])) best = {side};
      }
      // measured: of 89 objects that could be cut, 88 had a solid on one side of the cut with the
      // least volume.
      if (best.empty()) return best;
    }
    if (best.size() < 2) return best;
    // Both sides are solids now, so a neighbour of a cut that failed may be better: that cut may
    // have missed the true border by little.
    for (const Cut& cut : neighbours) {
      if (fits_ >= kMaxFits) break;
      std::array<Part, 2> sides = SidesOf(cut, open);
      if (sides[0].fit && sides[1].fit) offer(std::move(sides));
    }
    return best;
  }

  // True if `part` is the better one to cut off: boxes as thin as a sheet come last, because a
  // sheet can be cut off along the flush faces of several objects; then the number of points
  // decides.
  bool IsBetterCutOff(const Part& part, const Part& other) const {
    const auto rank = [&](const Part& p) {
      const auto* box = std::get_if<Box>(&p.fit->solid.shape);
      const bool is_sheet = box && box->size_m.minCoeff() <= 2 * c_.points.max_gate_m;
      return std::pair(!is_sheet, p.members.size());
    };
    return rank(part) > rank(other);
  }

  double ValueOf(const std::vector<Solid>& solids, const Members& members) const {
    const ModelPoints own = Subset(c_.points, members);
    return FitScoreOf(solids, ContextFor(own, subsampled_rays_)).value;
  }

  FitContext ContextFor(const ModelPoints& own, const FreeRays& free) const {
    return {own, c_.octree, c_.connectivity, c_.noise, c_.options, c_.work, c_.ground, free};
  }

  // The part with all open points that lie on its solid, which are removed from `open`: cuts run
  // beside the true border.
  Part WithPointsOnSolid(Part part, Members& open) const {
    Members rest;
    part.members.clear();
    for (std::uint32_t i : open) (IsOn(part, i) ? part.members : rest).push_back(i);
    open = std::move(rest);
    return part;
  }

  // Fits a solid to each part, in parallel.
  void FitEach(std::span<Part> parts) {
    ParallelFor(parts.size(), 1, c_.work, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) parts[k].fit = FitPart(parts[k].members);
    });
  }

  std::optional<PrimitiveFit> FitPart(Members members) {
    if (!IsEnough(members)) return std::nullopt;
    ModelPoints own = Subset(c_.points, members);
    ++fits_;
    std::optional<PrimitiveFit> fit = FindBetterPrimitive(ContextFor(own, subsampled_rays_), {});
    // Points off the solid may have drawn its ends to where none of its own points are, so it is
    // fitted again without them.
    while (fit) {
      Members on;
      for (std::uint32_t i : fit->solid.inliers) on.push_back(members[i]);
      if (static_cast<double>(on.size()) >=
          (1 - kMaxBeyondGates) * static_cast<double>(members.size())) {
        fit->solid.inliers.clear();
        break;
      }
      members = std::move(on);
      if (!IsEnough(members)) return std::nullopt;
      own = Subset(c_.points, members);
      fit = Refit(*fit, ContextFor(own, subsampled_rays_));
    }
    return fit;
  }
  bool IsEnough(const Members& members) const {
    return static_cast<double>(members.size()) * c_.points.weight >= c_.options.min_inliers;
  }

  double Distance_m(const Part& part, std::uint32_t i) const {
    const Solid& solid = part.fit->solid;
    return std::abs(SignedDistance_m(solid, solid.X_MS.inverse(Eigen::Isometry) * c_.points.p[i]));
  }
  bool IsOn(const Part& part, std::uint32_t i) const {
    return Distance_m(part, i) <= c_.points.gate_m[i];
  }

  // Moves each point off its own solid to the part whose solid is nearest, and fits all parts
  // again.
  std::vector<Part> Reassigned(std::vector<Part> parts) {
    std::vector<Members> members(parts.size());
    std::vector<char> settled(c_.points.size(), 0);
    for (std::size_t k = 0; k < parts.size(); ++k) {
      for (std::uint32_t i : parts[k].members) {
        if (!IsOn(parts[k], i)) continue;
        settled[i] = 1;
        members[k].push_back(i);
      }
    }
    for (std::uint32_t i = 0; i < c_.points.size(); ++i) {
      if (settled[i]) continue;
      std::vector<double> distances_m;
      for (const Part& part : parts) distances_m.push_back(Distance_m(part, i));
      const auto nearest = std::ranges::min_element(distances_m) - distances_m.begin();
      members[static_cast<std::size_t>(nearest)].push_back(i);
    }
    for (Members& of_part : members) std::ranges::sort(of_part);
    std::vector<Part> refitted;
    for (Members& of_part : members) refitted.push_back({std::move(of_part), {}});
    FitEach(refitted);
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (refitted[k].fit) parts[k] = std::move(refitted[k]);
    }
    return parts;
  }

  // Merges parts that one solid explains together.
  std::vector<Part> Merged(std::vector<Part> parts) {
    for (std::size_t a = 0; a < parts.size(); ++a) {
      for (std::size_t b = a + 1; b < parts.size();) {
        if (parts.size() == 2) return parts;  // no single solid explains all points
        Members both;
        std::ranges::set_union(parts[a].members, parts[b].members, std::back_inserter(both));
        std::optional<PrimitiveFit> fit = FitPart(both);
        if (!fit) {
          ++b;
          continue;
        }
        parts[a] = {std::move(both), std::move(fit)};
        parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(b));
        b = a + 1;
      }
    }
    return parts;
  }

  const FitContext& c_;
  const GroundPlan plan_;
  const FreeRays subsampled_rays_ = SubsampledRays(c_.free);  // used while parts are sought
  std::atomic<std::size_t> fits_ = 0;
};

// The known solids nearly all of whose points no part explains, such as a ball between two boxes.
std::vector<Solid> UnexplainedKnownSolids(const std::vector<Solid>& known,
                                          const std::vector<Solid>& parts,
                                          const ModelPoints& points) {
  const std::vector<char> on = MarkPointsOnSolids(parts, points);
  std::vector<Solid> unexplained;
  for (const Solid& solid : known) {
    const auto free = std::ranges::count_if(solid.inliers, [&](std::uint32_t i) { return !on[i]; });
    if (static_cast<double>(free) >= kNearlyAll * static_cast<double>(solid.inliers.size())) {
      unexplained.push_back(solid);
    }
  }
  return unexplained;
}

// True if there is a single solid that explains all points but mixed pixels, and at most half of
// kMaxPassedBeside of the free rays enter it.
bool IsExplainedBySingleSolid(const std::vector<Solid>& solids, const FitContext& c) {
  return solids.size() == 1 && IsFullyExplained(solids, c) &&
         CrossingRayShare(solids.front(), c.free) <= kMaxPassedBeside / 2;
}

bool ExplainNearlyAll(const std::vector<Solid>& solids, const FitContext& c) {
  return static_cast<double>(std::ranges::count(MarkPointsOnSolids(solids, c.points), 1)) >=
         kNearlyAll * static_cast<double>(c.points.size());
}

// True if the hulls of the parts, seen from above, overlap by less than a piece; borders blur by a
// few pixels. Parts about a common axis, or one on the other, were not cut where objects touch.
bool AreSideBySide(const std::vector<Part>& parts, const GroundPlan& plan) {
  std::vector<Vector2> all;
  double sum_m2 = 0;
  for (const Part& part : parts) {
    std::vector<Vector2> own;
    for (std::uint32_t i : part.members) own.push_back(plan.At(i));
    all.insert(all.end(), own.begin(), own.end());
    sum_m2 += HullArea_m2(std::move(own));
  }
  return sum_m2 <= (1 + kMinPiece) * HullArea_m2(std::move(all));
}

// The largest value at which so many parts are preferred to the solids as they are, and to a single
// solid for all points. Fewer solids than before win without a margin over them.
double MaxValue(const std::vector<Solid>& solids, std::size_t parts, const FitContext& c) {
  const FitScore assembled = FitScoreOf(AnyOverlap(solids) ? std::vector<Solid>() : solids, c);
  const double apart = (parts < solids.size() ? 1 : kMaxValueRatioToSeveral) * assembled.value;
  const std::optional<PrimitiveFit> single = FindBetterPrimitive(c, {});
  return single ? std::min(apart, kMaxValueRatioToOne * single->value) : apart;
}

}  // namespace

bool ReplaceBySplitSolids(const FitContext& context, Assembly& assembly) {
  if (!context.options.split_touching || !context.ground.known ||
      IsExplainedBySingleSolid(assembly.solids, context)) {
    return false;
  }
  SolidSplitter splitter(context);
  const std::optional<std::vector<Part>> parts = splitter.Run();
  if (!parts || parts->size() < 2 || !AreSideBySide(*parts, GroundPlan(context))) return false;
  std::vector<Solid> solids;
  for (const Part& part : *parts) solids.push_back(splitter.SolidOf(part));
  std::ranges::move(UnexplainedKnownSolids(assembly.solids, solids, context.points),
                    std::back_inserter(solids));
  if (AnyOverlap(solids) || !ExplainNearlyAll(solids, context) ||
      FitScoreOf(solids, context).value > MaxValue(assembly.solids, solids.size(), context)) {
    return false;
  }
  const bool any_crossed =
      std::ranges::any_of(solids, [&](const Solid& s) { return IsCrossed(s, context); });
  if (any_crossed) return false;
  ShrinkToFreeSpace(context,
                    std::span(solids).first(parts->size()));  // known ones have been narrowed
  assembly.solids = std::move(solids);
  return true;
}

}  // namespace cwm::perception
