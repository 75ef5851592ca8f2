// A random table and a camera that sees it, which a family of scenes fills.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "perception/simulation/proposals.h"
#include "perception/simulation/random_scenes.h"

namespace cwm::perception {

// Places that are tried for an object; a table with room has one within a few.
inline constexpr int kPlacementAttempts = 40;
// Draws per wanted object. Objects without a place are left out.
inline constexpr int kDrawsPerObject = 6;

struct Table {
  RestingArea area;
  Disc spread;  // where objects go
  Arrangement arrangement;

  std::size_t object_count() const {
    return arrangement.scene().objects.size() - arrangement.furniture_count();
  }
};

// The number of objects in a scene.
struct ObjectCountRange {
  int min = 0;
  int max = 0;
};

// Puts `wanted` objects on the table, a number drawn between min and max; fewer if there is no
// room.
using TableFiller = std::function<void(int wanted, Table& table, RandomDraws& draws)>;

// The target of the camera: the middle of the table, or one of its edges.
enum class TableMiddle { kInView, kEdgeInView };

// Draws a view. If fewer objects than the minimum find a place, draws another one.
SimulatedView DrawTableView(SceneFamily family, std::uint64_t seed, const ObjectCountRange& count,
                            const ArrangementRules& rules, const TableFiller& fill,
                            TableMiddle middle = TableMiddle::kInView);

}  // namespace cwm::perception
