// Scenes drawn at random with a camera that sees them: what perception is measured on.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// kTable    a table with 4 to 9 separate things (cylinders, spheres, cups, boxes) that hide at most
//           a fifth of each other, seen from 0.6 to 1.2 m and 20 to 70 degrees above, from any
//           side. About a third of those that can lie or lean do; a leaning one touches what holds
//           it, all others are at least 20 mm apart.
// kClutter  the same with 8 to 16 things closer together, some of them touching: 20 to 70 % of many
//           of them is hidden, never more.
// kKitchen  a wall, a counter on its cabinet with fronts, a shelf above, a lower side table, and on
//           each of them packets, cans, mugs, pans and jugs.
// kVessels  a table with mugs, pans and jugs, and boxes that touch some of them where a handle
//           could be.
// kStacks   a table with two to four stacks about one axis (groups.h) and single things.
// kHeaps    a table with one or two heaps of books and flat boxes, up to 15 in all, and single things.
// kRows     a table with one or two rows of things of one height, and single things.
// kLids     a table with four to eight cans, jars and boxes with lids.
// kEdges    things as of kTable at and over an edge of the table, their middle above it.
// Others hide up to four fifths of a thing in kStacks, kHeaps and kRows.
enum class SceneFamily {
  kTable,
  kClutter,
  kKitchen,
  kVessels,
  kStacks,
  kHeaps,
  kRows,
  kLids,
  kEdges
};

struct NamedFamily {
  std::string_view name;  // as the command line and the figures have it
  SceneFamily family = SceneFamily::kTable;
};
inline constexpr std::array<NamedFamily, 9> kSceneFamilies = {{{"table", SceneFamily::kTable},
                                                               {"clutter", SceneFamily::kClutter},
                                                               {"kitchen", SceneFamily::kKitchen},
                                                               {"vessels", SceneFamily::kVessels},
                                                               {"stacks", SceneFamily::kStacks},
                                                               {"heaps", SceneFamily::kHeaps},
                                                               {"rows", SceneFamily::kRows},
                                                               {"lids", SceneFamily::kLids},
                                                               {"edges", SceneFamily::kEdges}}};

struct SimulatedView {
  SimulatedScene scene;
  PinholeCamera camera;
};

// World: z up, floor at z = 0. Nothing interpenetrates; every object that is no furniture is at
// least partly in view. Furniture comes first, supports before all else. The names are unique. Same
// seed, same bytes.
SimulatedView RandomScene(SceneFamily family, std::uint64_t seed);

}  // namespace cwm::perception
