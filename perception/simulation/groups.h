// Groups of objects that touch each other, such as stacks and heaps. They are placed as one object
// and are several objects in the scene.
#pragma once

#include <string>
#include <vector>

#include "perception/simulation/random_draws.h"
#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// Members that touch. X_WO of each is its pose in the group's frame, with z up and z = 0 on the
// support. At least one member stands on the support.
struct Group {
  std::vector<SimulatedObject> members;
};

// Merges the members' parts into one object, in the group's frame.
SimulatedObject MergedObject(const Group& group);

// Returns the members, placed like the one object.
std::vector<SimulatedObject> MembersOf(const Group& group, const SimulatedObject& placed);

// Two to four objects about one axis, each on the one below: cans and tins of one width or several,
// cups and bowls with the wide side up or down, or nested cups whose rims are visible. Axes are at
// most 2 mm apart.
Group DrawStack(RandomDraws& draws);

// Three to `max_members` books and flat boxes, each on the table, on another one (at any angle, or
// square to it), or leaning over the edge of one.
Group DrawHeap(int max_members, RandomDraws& draws);

// Three to six packets, books or cans of equal height (to 1 mm) side by side: touching or up to 4
// mm apart, with faces flush to 20 mm.
Group DrawRow(RandomDraws& draws);

// A can, jar or box with a lid, at most 3 mm wider or narrower and 2 to 15 mm high: one object of
// two parts.
SimulatedObject DrawLiddedObject(RandomDraws& draws);

}  // namespace cwm::perception
