#include "perception/refinement/reassign/reassign_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>

#include "perception/cloud/seen_width.h"
#include "perception/cloud/slenderness.h"
#include "perception/cloud/tolerances.h"
#include "perception/handles/vessel_handles.h"
#include "perception/refinement/evidence.h"
#include "perception/search/model_points.h"

namespace cwm::perception {
namespace {

// Indices of a proposal's products.
enum : std::size_t { kGiver, kTaker };

bool HasVessel(const HypothesisModel& model) {
  return std::ranges::any_of(model.shapes(),
                             [](const ShapePart& part) { return part.vessel != nullptr; });
}

// True if the two ends of a handle lie nearer to the taker's shapes than to the giver's, in sum by
// more than kExplainedWithin_m.
bool IsHandleOf(const OrientedPoints& all, const PointSet& handle, const HypothesisModel& giver,
                const HypothesisModel& taker) {
  if (handle.empty()) return false;
  std::vector<Eigen::Vector3f> places;
  for (std::uint32_t i : handle) places.push_back(all.points[i]);
  const Slenderness bar =
      MeasureSlenderness(places, all.viewpoint, SeenPitch_m(places, all.viewpoint));
  double nearer_m = 0;
  for (const Vector3& end : bar.ends) {
    nearer_m += DistanceToShapes_m(giver.shapes(), end) - DistanceToShapes_m(taker.shapes(), end);
  }
  return nearer_m > kExplainedWithin_m;
}

// Points of the giver that are likely the taker's. Ascending.
PointSet PointsFor(const OrientedPoints& all, const ObjectHypothesis& giver,
                   const ObjectHypothesis& taker) {
  PointSet given;
  for (const std::uint32_t i : PointsOfPart(giver, kUnexplained)) {
    const double off_m = DistanceToShapes_m(taker.model->shapes(), all.points[i].cast<double>());
    if (off_m <= ExplainedWithin_m(all.sigma_m[i])) given.push_back(i);
  }
  if (HasVessel(*taker.model)) {
    for (std::size_t h = 0; h < giver.model->handles().size(); ++h) {
      const PointSet handle = PointsOfHandle(giver, h);
      if (!IsHandleOf(all, handle, *giver.model, *taker.model)) continue;
      given.insert(given.end(), handle.begin(), handle.end());
    }
  }
  std::ranges::sort(given);
  return given;
}

std::size_t WithoutShape(const HypothesisModel& model) {
  return static_cast<std::size_t>(std::ranges::count(model.part_of_point(), kUnexplained));
}

// The number of the giver's handles of which points are given, and the number of these points. They
// may not be handles at all.
struct GivenHandles {
  std::size_t handles = 0, points = 0;
};
GivenHandles HandlesAmong(const PointSet& given, const ObjectHypothesis& giver) {
  GivenHandles found;
  for (std::size_t h = 0; h < giver.model->handles().size(); ++h) {
    const PointSet handle = PointsOfHandle(giver, h);
    const auto among = static_cast<std::size_t>(std::ranges::count_if(
        handle, [&](std::uint32_t i) { return std::ranges::binary_search(given, i); }));
    found.handles += among > 0;
    found.points += among;
  }
  return found;
}

class ReassignPoints : public RefinementPass {
 public:
  std::string_view Name() const override { return "reassign.points"; }
  std::span<const std::string_view> After() const override;
  TrialBudget MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // The decrease of unexplained points minus half of the given points; 0 if a handle is lost that
  // was not given.
  double Gain(const ModelledProposal& modelled) const override;
};

}  // namespace

std::span<const std::string_view> ReassignPoints::After() const {
  static constexpr std::array<std::string_view, 1> kAfter = {"merge.occluded_parts"};
  return kAfter;
}

TrialBudget ReassignPoints::MaxWork() const {
  return {.note = "parts of it may belong to what touches it: the cap of trades was reached"};
}

std::vector<Proposal> ReassignPoints::Propose(const SceneState& state,
                                              const RefinementContext& context) const {
  std::vector<Proposal> proposals;
  for (const HypothesisPtr& giver : state.objects()) {
    for (const HypothesisPtr& taker : state.objects()) {
      if (giver->id == taker->id || taker->model->shapes().empty()) continue;
      if (giver->model->is_given || taker->model->is_given) continue;
      if (giver->model->bounds_L.exteriorDistance(taker->model->bounds_L) > kMaxTouchingGap_m)
        continue;
      context.work.Poll();
      const PointSet given = PointsFor(state.points(), *giver, *taker);
      if (given.size() < kMinHandlePoints || given.size() == giver->points.size()) continue;
      const std::size_t nodes = NodesOf(*giver, given.size());
      proposals.push_back({.consumes = {{giver->id, kGiver}, {taker->id, kTaker}},
                           .products = {Without(*giver, given), With(*taker, given, nodes)}});
    }
  }
  return proposals;
}

double ReassignPoints::Gain(const ModelledProposal& modelled) const {
  const ObjectHypothesis& giver = modelled.state.Get(modelled.proposal.consumes[kGiver].id);
  const ObjectHypothesis& taker = modelled.state.Get(modelled.proposal.consumes[kTaker].id);
  PointSet given;
  std::ranges::set_difference(giver.points, modelled.proposal.products[kGiver].points,
                              std::back_inserter(given));
  const GivenHandles given_handles = HandlesAmong(given, giver);
  // Given points of a handle count as unexplained before: they belonged to the wrong object.
  const std::size_t before =
      WithoutShape(*giver.model) + given_handles.points + WithoutShape(*taker.model);
  const std::size_t after =
      WithoutShape(*modelled.products[kGiver]) + WithoutShape(*modelled.products[kTaker]);
  const std::size_t handles_before = giver.model->handles().size() + taker.model->handles().size();
  const std::size_t handles_after =
      modelled.products[kGiver]->handles().size() + modelled.products[kTaker]->handles().size();
  if (handles_after + given_handles.handles < handles_before) return 0;
  return static_cast<double>(before) - static_cast<double>(after) -
         0.5 * static_cast<double>(given.size());
}

std::unique_ptr<const RefinementPass> MakeReassignPoints() {
  return std::make_unique<const ReassignPoints>();
}

}  // namespace cwm::perception
