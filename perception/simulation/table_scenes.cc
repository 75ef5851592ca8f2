#include "perception/simulation/table_scenes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "perception/simulation/household_goods.h"
#include "perception/simulation/proposals.h"
#include "perception/simulation/table_view.h"
#include "perception/simulation/vessels.h"

namespace cwm::perception {
namespace {

// The share of tilted rests is raised, so that a third remains after impossible draws (spheres,
// discs, no holder).
RestPose DrawRest(GoodsKind kind, RandomDraws& draws) {
  constexpr double kTilted = 0.42;
  constexpr double kLeaningCylinders = 0.3;  // of the tilted ones
  const double share = draws.Uniform();
  const double lean = draws.Uniform();
  if (share > kTilted) return RestPose::kStanding;
  if (kind == GoodsKind::kBox) return RestPose::kLeaning;
  if (kind == GoodsKind::kCylinder && lean < kLeaningCylinders) return RestPose::kLeaning;
  return RestPose::kLying;
}

SimulatedObject DrawObject(RandomDraws& draws) {
  const auto kind = static_cast<GoodsKind>(draws.Below(kGoodsKindCount));
  const RestPose rest = DrawRest(kind, draws);
  return DrawGoods(kind, rest, draws);
}

// True if another object has to hold it: it is neither upright nor on its side. A lying cup's axis
// is off the horizontal by its half angle.
bool Leans(const SimulatedObject& object) {
  constexpr double kRounding = 1e-9;
  const Placed<>& part = object.parts.front();
  const double upright = std::abs(part.X_FS.linear()(2, 2));
  return !std::holds_alternative<Cone>(part.shape) && upright > kRounding &&
         upright < 1 - kRounding;
}

// Adds separate objects.
void FillTable(int wanted, Table& table, RandomDraws& draws) {
  for (int i = 0, added = 0; i < kDrawsPerObject * wanted && added < wanted; ++i) {
    const SimulatedObject object = DrawObject(draws);
    for (int attempt = 0; attempt < kPlacementAttempts; ++attempt) {
      auto proposal =
          Leans(object) ? ProposeLeaning(table.arrangement, table.area, object, draws)
                        : ProposeWithin(table.spread, table.arrangement, table.area, object, draws);
      if (!proposal) continue;
      AddNumbered(*std::move(proposal), table.arrangement);
      ++added;
      break;
    }
  }
}

std::ptrdiff_t CountHidden(const Placement& proposal) {
  constexpr double kHiddenInPart = 0.2;
  return std::count_if(proposal.hidden_shares.begin(), proposal.hidden_shares.end(),
                       [](double share) { return share >= kHiddenInPart; });
}

std::optional<Placement> ProposeInClutter(const Table& table, const SimulatedObject& object,
                                          RandomDraws& draws) {
  constexpr double kBesideProbability = 0.7;
  // Heaps grow outwards from the middle.
  const Disc middle{.middle_W = table.spread.middle_W, .radius_m = 0.6 * table.spread.radius_m};
  if (Leans(object)) return ProposeLeaning(table.arrangement, table.area, object, draws);
  if (draws.Uniform() < kBesideProbability) {
    return ProposeBeside(table.arrangement, table.area, object, draws);
  }
  return ProposeWithin(middle, table.arrangement, table.area, object, draws);
}

// For each object, selects the one of several places that leaves most objects partly hidden.
void FillClutter(int wanted, Table& table, RandomDraws& draws) {
  for (int i = 0, added = 0; i < kDrawsPerObject * wanted && added < wanted; ++i) {
    const SimulatedObject object = DrawObject(draws);
    std::optional<Placement> best;
    for (int attempt = 0; attempt < kPlacementAttempts; ++attempt) {
      auto proposal = ProposeInClutter(table, object, draws);
      if (proposal && (!best || CountHidden(*proposal) > CountHidden(*best))) best = proposal;
    }
    if (!best) continue;
    AddNumbered(*std::move(best), table.arrangement);
    ++added;
  }
}

// A box between the size of a handle with the space behind it and that of a packet of tea.
SimulatedObject DrawSmallBox(RandomDraws& draws) {
  constexpr double kLargest_m = 0.12;
  for (;;) {
    SimulatedObject box = DrawGoods(GoodsKind::kBox, RestPose::kStanding, draws);
    if (BoundsInWorld(box).sizes().maxCoeff() <= kLargest_m) return box;
  }
}

// About two thirds of `wanted` are vessels; the others are small boxes that touch one of them.
void FillVessels(int wanted, Table& table, RandomDraws& draws) {
  const int vessels = (2 * wanted + 2) / 3;
  for (int i = 0, added = 0; i < kDrawsPerObject * wanted && added < wanted; ++i) {
    const bool is_vessel = added < vessels;
    const SimulatedObject object =
        is_vessel ? DrawVessel(DrawVesselKind(draws), draws) : DrawSmallBox(draws);
    for (int attempt = 0; attempt < kPlacementAttempts; ++attempt) {
      auto proposal =
          is_vessel ? ProposeWithin(table.spread, table.arrangement, table.area, object, draws)
                    : ProposeTouching(table.arrangement.furniture_count() +
                                          static_cast<std::size_t>(draws.Below(vessels)),
                                      table.arrangement, table.area, object, draws);
      if (!proposal) continue;
      AddNumbered(*std::move(proposal), table.arrangement);
      ++added;
      break;
    }
  }
}

}  // namespace

SimulatedView RandomTableView(std::uint64_t seed) {
  return DrawTableView(SceneFamily::kTable, seed, {.min = 4, .max = 9},
                       {.min_gap_m = 0.02, .max_hidden = 0.2}, FillTable);
}

SimulatedView RandomClutterView(std::uint64_t seed) {
  return DrawTableView(SceneFamily::kClutter, seed, {.min = 8, .max = 16},
                       {.min_gap_m = 0.003, .max_hidden = 0.7}, FillClutter);
}

SimulatedView RandomVesselView(std::uint64_t seed) {
  return DrawTableView(SceneFamily::kVessels, seed, {.min = 4, .max = 8},
                       {.min_gap_m = 0.02, .max_hidden = 0.35}, FillVessels);
}

}  // namespace cwm::perception
