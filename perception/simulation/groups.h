// Things that touch each other, as stacks and heaps do: one object while a place for them is sought,
// several in the scene.
#pragma once

#include <string>
#include <vector>

#include "perception/simulation/random_draws.h"
#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// Members that touch; X_WO of each is its pose in the group's frame, which is z up with z = 0 the
// support. At least one stands on that.
struct Group {
  std::vector<SimulatedObject> members;
};

// The members' parts as the parts of one object, in the group's frame.
SimulatedObject AsOneObject(const Group& group);

// The members, placed as the one object is.
std::vector<SimulatedObject> MembersOf(const Group& group, const SimulatedObject& placed);

// Two to four things about one axis, each on the one below: cans and tins of one width or of
// several, cups and bowls, the wide side up or down; or cups nested in each other, of which the rims
// show. Axes are at most 2 mm apart.
Group DrawStack(RandomDraws& draws);

// Three to `most` books and flat boxes, each on the table, on others (turned by any angle, or square
// to what is below), or leaning over the edge of one.
Group DrawHeap(int most, RandomDraws& draws);

// Three to six packets, books or cans of one height, to 1 mm, side by side: touching or up to 4 mm
// apart, faces flush to 20 mm.
Group DrawRow(RandomDraws& draws);

// A can, jar or box with a lid that is at most 3 mm wider or narrower and 2 to 15 mm high: one
// object of two parts.
SimulatedObject DrawLidded(RandomDraws& draws);

}  // namespace cwm::perception
