#include "perception/simulation/touching_scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "perception/simulation/containers.h"
#include "perception/simulation/groups.h"
#include "perception/simulation/household_goods.h"
#include "perception/simulation/table_view.h"

namespace cwm::perception {
namespace {

constexpr ArrangementRules kTouching{.min_gap_m = 0.01, .max_hidden = 0.8};

SimulatedObject DrawSingle(RandomDraws& draws) {
  return DrawGoods(static_cast<GoodsKind>(draws.Below(kGoodsKindCount)), RestPose::kStanding,
                   draws);
}

bool AddSingle(const SimulatedObject& object, Table& table, RandomDraws& draws) {
  for (int attempt = 0; attempt < kPlacementAttempts; ++attempt) {
    auto proposal = ProposeWithin(table.spread, table.arrangement, table.area, object, draws);
    if (!proposal) continue;
    AddNumbered(*std::move(proposal), table.arrangement);
    return true;
  }
  return false;
}

// Adds the whole group, or nothing if a member would hardly be visible.
bool AddGroup(const Group& group, Table& table, RandomDraws& draws) {
  const SimulatedObject one = MergedObject(group);
  for (int attempt = 0; attempt < kPlacementAttempts; ++attempt) {
    auto proposal = ProposeWithin(table.spread, table.arrangement, table.area, one, draws);
    if (!proposal) continue;
    Arrangement with_group = table.arrangement;
    for (SimulatedObject& member : MembersOf(group, proposal->object)) {
      AddNumbered({.object = std::move(member), .hidden_shares = {}}, with_group);
    }
    if (!with_group.ShowsAll()) continue;
    table.arrangement = std::move(with_group);
    return true;
  }
  return false;
}

// Groups come first, as they need room; then single objects beside them.
struct Mixture {
  int groups = 0, singles = 0;
};

template <class DrawGroup>
void Fill(const Mixture& wanted, const DrawGroup& draw_group, Table& table, RandomDraws& draws) {
  for (int i = 0, added = 0; i < kDrawsPerObject * wanted.groups && added < wanted.groups; ++i) {
    added += AddGroup(draw_group(draws), table, draws);
  }
  for (int i = 0, added = 0; i < kDrawsPerObject * wanted.singles && added < wanted.singles; ++i) {
    added += AddSingle(DrawSingle(draws), table, draws);
  }
}

// Places the object over the edge that the camera looks at, with its middle above the table.
std::optional<SimulatedObject> PutAtEdge(SimulatedObject object, const Table& table,
                                         RandomDraws& draws) {
  const Eigen::AlignedBox2d& top = table.area.area_W;
  const Vector2 towards = -top.center();  // the camera looks at the world's z axis
  const bool along_x = std::abs(towards.x()) > std::abs(towards.y());
  const Eigen::Index across = along_x ? 0 : 1, along = along_x ? 1 : 0;
  object.X_WO = MakePose(
      {0, 0, table.area.top_m},
      Quaternion(Eigen::AngleAxisd(draws.Uniform(0, 2 * std::numbers::pi), Vector3::UnitZ())));
  const double half_m = 0.5 * BoundsInWorld(object).sizes()[across];
  const double edge_m = towards[across] > 0 ? top.max()[across] : top.min()[across];
  const double inwards = towards[across] > 0 ? -1 : 1;
  Vector2 place;
  place[across] = edge_m + inwards * half_m * draws.Uniform(0.3, 1.3);
  place[along] = draws.Uniform(-1, 1) * table.spread.radius_m;
  if (!top.contains(place)) return std::nullopt;
  object.X_WO.translation().head<2>() = place;
  return object;
}

void FillEdge(int wanted, Table& table, RandomDraws& draws) {
  for (int i = 0, added = 0; i < kDrawsPerObject * wanted && added < wanted; ++i) {
    const SimulatedObject drawn = DrawSingle(draws);
    for (int attempt = 0; attempt < kPlacementAttempts; ++attempt) {
      auto object = PutAtEdge(drawn, table, draws);
      if (!object) continue;
      auto shares = table.arrangement.HiddenSharesWith(*object, std::nullopt);
      if (!shares) continue;
      AddNumbered({.object = *std::move(object), .hidden_shares = {}}, table.arrangement);
      ++added;
      break;
    }
  }
}

}  // namespace

SimulatedView RandomStackView(std::uint64_t seed) {
  return DrawTableView(SceneFamily::kStacks, seed, {.min = 4, .max = 16}, kTouching,
                       [](int, Table& table, RandomDraws& draws) {
                         Fill({.groups = 2 + draws.Below(3), .singles = draws.Below(4)}, DrawStack,
                              table, draws);
                       });
}

SimulatedView RandomHeapView(std::uint64_t seed) {
  constexpr int kMax = 15;
  return DrawTableView(SceneFamily::kHeaps, seed, {.min = 4, .max = kMax}, kTouching,
                       [](int wanted, Table& table, RandomDraws& draws) {
                         const int heaps = 1 + draws.Below(2);
                         const auto draw = [&](RandomDraws& d) {
                           return DrawHeap(std::max(3, wanted / heaps), d);
                         };
                         Fill({.groups = heaps, .singles = draws.Below(3)}, draw, table, draws);
                       });
}

SimulatedView RandomRowView(std::uint64_t seed) {
  return DrawTableView(SceneFamily::kRows, seed, {.min = 3, .max = 12}, kTouching,
                       [](int, Table& table, RandomDraws& draws) {
                         Fill({.groups = 1 + draws.Below(2), .singles = draws.Below(4)}, DrawRow,
                              table, draws);
                       });
}

SimulatedView RandomLidView(std::uint64_t seed) {
  return DrawTableView(
      SceneFamily::kLids, seed, {.min = 4, .max = 8}, {.min_gap_m = 0.02, .max_hidden = 0.35},
      [](int wanted, Table& table, RandomDraws& draws) {
        for (int i = 0, added = 0; i < kDrawsPerObject * wanted && added < wanted; ++i) {
          added += AddSingle(DrawLiddedObject(draws), table, draws);
        }
      });
}

SimulatedView RandomEdgeView(std::uint64_t seed) {
  return DrawTableView(SceneFamily::kEdges, seed, {.min = 3, .max = 7},
                       {.min_gap_m = 0.02, .max_hidden = 0.35}, FillEdge, TableMiddle::kEdgeInView);
}

SimulatedView RandomContainerView(std::uint64_t seed) {
  return DrawTableView(
      SceneFamily::kContainers, seed, {.min = 3, .max = 10}, kTouching,
      [](int, Table& table, RandomDraws& draws) {
        Fill({.groups = 1 + draws.Below(2), .singles = 0}, DrawOpenBox, table, draws);
        const int vessels = 2 + draws.Below(3);
        for (int i = 0, added = 0; i < kDrawsPerObject * vessels && added < vessels; ++i) {
          added += AddSingle(DrawLyingVessel(draws), table, draws);
        }
      });
}

}  // namespace cwm::perception
