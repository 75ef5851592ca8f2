// A random table and the camera that sees it, to be filled by a family of scenes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "perception/simulation/proposals.h"
#include "perception/simulation/random_scenes.h"

namespace cwm::perception {

struct Table {
  RestingArea area;
  Disc spread;  // where objects go
  Arrangement arrangement;

  std::size_t thing_count() const {
    return arrangement.scene().objects.size() - arrangement.furniture_count();
  }
};

// How many things a scene holds.
struct ThingCount {
  int least = 0;
  int most = 0;
};

// Puts so many things, drawn between least and most, on the table; fewer where there is no room.
using TableFiller = std::function<void(int wanted, Table& table, RandomDraws& draws)>;

// Where the camera looks: at the middle of the table, or at one of its edges.
enum class TableMiddle { kInView, kEdgeInView };

// A view in which fewer than the least number of things found a place is drawn anew.
SimulatedView DrawTableView(SceneFamily family, std::uint64_t seed, const ThingCount& count,
                            const ArrangementRules& rules, const TableFiller& fill,
                            TableMiddle middle = TableMiddle::kInView);

}  // namespace cwm::perception
