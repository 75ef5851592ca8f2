#include "perception/refinement/merge/merge_tray_walls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>

#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/refinement/evidence.h"
#include "perception/refinement/merge/tray.h"
#include "perception/segmentation/plane_fit.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {
namespace {

// chosen: lines of places in a mouth and in a side, and places on each: about 300, as between two
// parts with something hidden between.
constexpr int kTrayLines = 24, kTrayPlaces = 12;

struct Found {
  Tray box;
  Pose X_LB;
  std::size_t support = 0;
  std::vector<const ObjectHypothesis*> parts = {};  // in the order of output
};

class TrayFinder {
 public:
  TrayFinder(const SceneState& state, const RefinementContext& context)
      : state_(state), context_(context) {}

  std::vector<Proposal> Run() {
    std::vector<Proposal> proposals;
    for (std::size_t s = 0; s < state_.support_count(); ++s) {
      for (const Found& found : FindOn(s)) proposals.push_back(ProposalOf(found));
    }
    return proposals;
  }

 private:
  std::vector<Found> FindOn(std::size_t support) const {
    const Pose& X_LP = state_.measured().supports[support].plate.X_FS;
    const Pose X_PL = X_LP.inverse(Eigen::Isometry);
    const Vector3 sensor_P = X_PL * state_.points().viewpoint;
    std::vector<LoneWall> walls;
    std::vector<const ObjectHypothesis*> owner_of_wall;
    for (const HypothesisPtr& hypothesis : state_.objects()) {
      if (hypothesis->resting.support != static_cast<std::int32_t>(support)) continue;
      if (hypothesis->model->is_given) continue;
      for (const ShapePart& part : hypothesis->model->shapes()) {
        const auto wall = AsLoneWall(part, X_PL, sensor_P);
        if (!wall) continue;
        walls.push_back(*wall);
        owner_of_wall.push_back(hypothesis.get());
      }
    }
    std::vector<Found> trays;
    for (Tray& box : FindTrays(walls, sensor_P)) {
      context_.work.Poll();
      const Pose X_LB = X_LP * box.X_PB;
      Found found{.box = std::move(box), .X_LB = X_LB, .support = support};
      if (!IsMouthOpen(found) || !AreWallsWhole(found)) continue;
      if (CollectParts(found, owner_of_wall)) trays.push_back(std::move(found));
    }
    return trays;
  }

  float Sigma_m(const ObjectHypothesis& hypothesis) const {
    return state_.points().sigma_m[hypothesis.points.front()];
  }

  struct Sight {
    int through = 0, on = 0, all = 0;

    bool IsMostlyThrough() const { return 2 * through > all; }
    void Add(const Sight& other) {
      through += other.through;
      on += other.on;
      all += other.all;
    }
  };

  // The visibility of kTrayPlaces places along a line.
  Sight LookAlong(const Vector3& begin_L, const Vector3& line_L) const {
    Sight sight;
    for (int k = 0; k < kTrayPlaces; ++k) {
      const Vector3 place = begin_L + (k + 0.5) / kTrayPlaces * line_L;
      const double range_m = (place - state_.points().viewpoint).norm();
      const auto sigma_m = static_cast<float>(context_.options.noise.AxialSigma_m(range_m));
      const Visibility seen =
          state_.sight()->VisibilityAt(place.cast<float>(), kGate_sigma * sigma_m);
      ++sight.all;
      sight.through += seen == Visibility::kSeenThrough;
      sight.on += seen == Visibility::kOnSurface;
    }
    return sight;
  }

  // The visibility of a rectangle, along each of several lines parallel to its y.
  std::vector<Sight> SightsAlong(const Vector3& corner_L, const Vector3& x_L,
                                 const Vector3& y_L) const {
    std::vector<Sight> sights;
    for (int k = 0; k < kTrayLines; ++k) {
      sights.push_back(LookAlong(corner_L + (k + 0.5) / kTrayLines * x_L, y_L));
    }
    return sights;
  }

  // True if rays pass through the mouth at the height of the rim; the top of a closed solid would
  // be seen there. Visible places that rays do not pass are on contents that reach up to the rim.
  bool IsMouthOpen(const Found& found) const {
    const Tray& box = found.box;
    const Vector2 size_m =
        box.size_m - 2 * Vector2::Constant(kEdgeLoss_m).cwiseMin(0.25 * box.size_m);
    const Vector3 corner(-0.5 * size_m.x(), -0.5 * size_m.y(), box.rim_m);
    const Matrix3 axes = found.X_LB.linear();
    Sight sight;
    for (const Sight& line :
         SightsAlong(found.X_LB * corner, size_m.x() * axes.col(0), size_m.y() * axes.col(1))) {
      sight.Add(line);
    }
    return sight.through >= kNearlyAll * (sight.through + sight.on) &&
           sight.through >= kMinInSight * sight.all;
  }

  // The visibility along each of several upright lines.
  std::vector<Sight> LookAtSide(const Found& found, std::size_t side) const {
    const Tray& box = found.box;
    const auto axis = static_cast<Eigen::Index>(side / 2);
    const double length_m =
        box.size_m(1 - axis) - 2 * std::min(kEdgeLoss_m, 0.25 * box.size_m(1 - axis));
    Vector3 corner = Vector3::Zero();
    corner(axis) = (side % 2 == 0 ? 0.5 : -0.5) * box.size_m(axis);
    corner(1 - axis) = -0.5 * length_m;
    const Matrix3 axes = found.X_LB.linear();
    return SightsAlong(found.X_LB * corner, length_m * axes.col(1 - axis), box.rim_m * axes.col(2));
  }

  // True if the pieces of a side are not one wall: rays pass along its whole height, from near its
  // foot, where the support is as near, up to its rim. A grip hole is lower.
  bool HasGap(const Found& found, std::size_t side) const {
    return std::ranges::any_of(LookAtSide(found, side),
                               [](const Sight& line) { return line.IsMostlyThrough(); });
  }

  bool IsSideOpen(const Found& found, std::size_t side) const {
    Sight sight;
    for (const Sight& line : LookAtSide(found, side)) sight.Add(line);
    return sight.IsMostlyThrough();
  }

  bool AreWallsWhole(const Found& found) const {
    for (std::size_t k = 0; k < found.box.sides.size(); ++k) {
      if (found.box.sides[k].in_pieces && HasGap(found, k)) return false;
    }
    return true;
  }

  // The share of points within a wall's thickness of the sides, or on the floor, within the heights
  // at which a floor can appear above the support.
  double ShareOnTray(const Found& found, const ObjectHypothesis& hypothesis) const {
    const Pose X_BL = found.X_LB.inverse(Eigen::Isometry);
    const double floor_m =
        OrientedPoints::PlaneTolerance_m(state_.points().spread.usual, Sigma_m(hypothesis));
    const std::vector<Eigen::Vector3f>& points = hypothesis.model->thinned_L;
    const auto on = std::ranges::count_if(points, [&](const Eigen::Vector3f& p) {
      const Vector3 p_B = X_BL * p.cast<double>();
      if (p_B.z() > found.box.rim_m + kVesselWall_m) return false;
      return found.box.ToSides_m(p_B) <= kVesselWall_m ||
             (found.box.IsOver(p_B) && p_B.z() <= floor_m);
    });
    return static_cast<double>(on) / static_cast<double>(points.size());
  }

  // Collects the objects that are parts of the tray. False if a wall belongs to another object.
  bool CollectParts(Found& found, const std::vector<const ObjectHypothesis*>& owner_of_wall) const {
    for (const HypothesisPtr& hypothesis : state_.hypotheses()) {
      const std::int32_t on = hypothesis->resting.support;
      if (on >= 0 && on != static_cast<std::int32_t>(found.support)) continue;
      if (!hypothesis->plates.empty() || hypothesis->model->thinned_L.empty()) continue;
      if (hypothesis->model->is_given) continue;
      if (ShareOnTray(found, *hypothesis) >= kMainShare) found.parts.push_back(hypothesis.get());
    }
    return std::ranges::all_of(found.box.walls, [&](std::size_t wall) {
      return std::ranges::count(found.parts, owner_of_wall[wall]) > 0;
    });
  }

  Proposal ProposalOf(const Found& found) const {
    std::vector<HypothesisId> ids;
    Proposal proposal;
    for (const ObjectHypothesis* part : found.parts) {
      ids.push_back(part->id);
      proposal.consumes.push_back({part->id});
    }
    Product whole = Merged(state_, ids);
    whole.resting = {.support = static_cast<std::int32_t>(found.support)};
    const std::size_t of_parts = whole.points.size();
    const Pose X_BL = found.X_LB.inverse(Eigen::Isometry);
    FromSupport from_support{.support = found.support};
    for (std::uint32_t i : state_.support(found.support).points) {
      if (!found.box.IsOver(X_BL * state_.points().points[i].cast<double>())) continue;
      from_support.points.push_back(i);
      whole.points.push_back(i);
    }
    std::ranges::sort(from_support.points);
    std::ranges::sort(whole.points);
    whole.node_count = whole.node_count * whole.points.size() / of_parts;
    std::vector<double> heights_m = HeightsOfFloor(found, whole.points);
    const bool sees_floor = heights_m.size() >= kThreeSamples;
    const double floor_m = sees_floor ? Quantile(std::move(heights_m), 0.5) : 0;
    whole.given_shapes = ShapesOf(found, floor_m, sees_floor);
    for (const HypothesisPtr& other : state_.objects()) {
      if (std::ranges::count(found.parts, other.get()) == 0 && StandsIn(found, *other, floor_m)) {
        proposal.resting_updates.push_back({other->id, 0, std::max(0.0, floor_m)});
      }
    }
    proposal.products.push_back(std::move(whole));
    if (!from_support.points.empty()) proposal.from_support = std::move(from_support);
    return proposal;
  }

  std::vector<ShapePart> ShapesOf(const Found& found, double floor_m, bool sees_floor) const {
    std::array<PartOrigin, 4> sides{};
    for (std::size_t k = 0; k < sides.size(); ++k) {
      sides[k] = found.box.sides[k].is_seen ? PartOrigin::kMeasured
                 : IsSideOpen(found, k)     ? PartOrigin::kNone
                                            : PartOrigin::kCompleted;
    }
    const Pose X_LP = found.X_LB * found.box.X_PB.inverse(Eigen::Isometry);
    std::vector<ShapePart> parts = PartsOf(
        found.box, sides, floor_m, sees_floor ? PartOrigin::kMeasured : PartOrigin::kCompleted);
    for (ShapePart& part : parts) part.X_OS = X_LP * part.X_OS;
    return parts;
  }

  // The heights of points within the sides that are no higher than a floor can appear above the
  // support.
  std::vector<double> HeightsOfFloor(const Found& found, const PointSet& points) const {
    const Pose X_BL = found.X_LB.inverse(Eigen::Isometry);
    std::vector<double> heights_m;
    for (std::uint32_t i : points) {
      const Vector3 p_B = X_BL * state_.points().points[i].cast<double>();
      if (!found.box.IsOver(p_B) || found.box.ToSides_m(p_B) <= kVesselWall_m) continue;
      if (p_B.z() <= double{state_.points().UsualPlaneTolerance_m(i)}) heights_m.push_back(p_B.z());
    }
    return heights_m;
  }

  bool StandsIn(const Found& found, const ObjectHypothesis& other, double floor_m) const {
    if (other.resting.support != static_cast<std::int32_t>(found.support)) return false;
    if (other.resting.on || other.model->thinned_L.empty()) return false;
    const Pose X_BL = found.X_LB.inverse(Eigen::Isometry);
    std::size_t within = 0;
    double foot_m = found.box.rim_m;
    for (const Eigen::Vector3f& p : other.model->thinned_L) {
      const Vector3 p_B = X_BL * p.cast<double>();
      within += found.box.IsOver(p_B);
      foot_m = std::min(foot_m, p_B.z());
    }
    return static_cast<double>(within) >=
               kNearlyAll * static_cast<double>(other.model->thinned_L.size()) &&
           foot_m <= floor_m + double{MaxJump_m(Sigma_m(other))};
  }

  const SceneState& state_;
  const RefinementContext& context_;
};

class MergeTrayWalls : public RefinementPass {
 public:
  std::string_view Name() const override { return "merge.tray_walls"; }
  std::span<const std::string_view> After() const override;
  TrialBudget MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // The number of hypotheses that become one tray. Every proposal gains, because the walls prove
  // the tray, and its shapes follow from them.
  double Gain(const ModelledProposal& modelled) const override;
};

}  // namespace

std::span<const std::string_view> MergeTrayWalls::After() const {
  static constexpr std::array<std::string_view, 1> kAfter = {"split.standing_solids"};
  return kAfter;
}

TrialBudget MergeTrayWalls::MaxWork() const {
  // Walls are merged without a search for shapes, so the work is one test per point.
  return {.max_trials = kMaxTrials, .points_divisor = 1, .note = "it may be a part of a tray"};
}

std::vector<Proposal> MergeTrayWalls::Propose(const SceneState& state,
                                              const RefinementContext& context) const {
  if (!state.sight()) return {};
  return TrayFinder(state, context).Run();
}

double MergeTrayWalls::Gain(const ModelledProposal& modelled) const {
  return static_cast<double>(modelled.proposal.consumes.size());
}

std::unique_ptr<const RefinementPass> MakeMergeTrayWalls() {
  return std::make_unique<const MergeTrayWalls>();
}

}  // namespace cwm::perception
