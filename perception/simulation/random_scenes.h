// Random scenes with a camera that sees them, on which perception is measured.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// kTable    a table with 4 to 9 separate objects (cylinders, spheres, cups, boxes) that hide at
//           most a fifth of each other, seen from 0.6 to 1.2 m and 20 to 70 degrees above, from any
//           side. About a third of those that can lie or lean do; a leaning one touches its holder,
//           all others are at least 20 mm apart.
// kClutter  the same with 8 to 16 objects closer together, some of them touching: 20 to 70 % of
//           many of them is hidden, never more.
// kKitchen  a wall, a counter on its cabinet with fronts, a shelf above, a lower side table, and on
//           each of them goods, mugs, pans and jugs.
// kVessels  a table with mugs, pans and jugs, and boxes that touch some of them at places where a
//           handle could be.
// kStacks   a table with two to four stacks about one axis (groups.h) and single objects.
// kHeaps    a table with one or two heaps of books and flat boxes, up to 15 in total, and single
//           objects.
// kRows     a table with one or two rows of objects of equal height, and single objects.
// kLids     a table with four to eight cans, jars and boxes with lids.
// kEdges    standing goods at and over an edge of the table, with their middle above the table.
// kContainers  a table with one or two open boxes, most with goods in them, and vessels that lie on
//           their side (containers.h).
// Up to four fifths of an object is hidden in kStacks, kHeaps, kRows and kContainers.
enum class SceneFamily {
  kTable,
  kClutter,
  kKitchen,
  kVessels,
  kStacks,
  kHeaps,
  kRows,
  kLids,
  kEdges,
  kContainers
};

struct NamedFamily {
  std::string_view name;  // as on the command line and in figures
  SceneFamily family = SceneFamily::kTable;
};
inline constexpr std::array<NamedFamily, 10> kSceneFamilies = {
    {{"table", SceneFamily::kTable},
     {"clutter", SceneFamily::kClutter},
     {"kitchen", SceneFamily::kKitchen},
     {"vessels", SceneFamily::kVessels},
     {"stacks", SceneFamily::kStacks},
     {"heaps", SceneFamily::kHeaps},
     {"rows", SceneFamily::kRows},
     {"lids", SceneFamily::kLids},
     {"edges", SceneFamily::kEdges},
     {"containers", SceneFamily::kContainers}}};

struct SimulatedView {
  SimulatedScene scene;
  PinholeCamera camera;
};

// World: z up, floor at z = 0. Objects do not interpenetrate, and all but furniture are at least
// partly visible. Furniture comes first, with supports before all else. Names are unique. The same
// seed gives the same bytes.
SimulatedView RandomScene(SceneFamily family, std::uint64_t seed);

}  // namespace cwm::perception
