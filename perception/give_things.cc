#include "perception/give_things.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace cwm::perception {
namespace {

// Removes things without points and brings the rest in order.
void Tidy(std::vector<SegmentedThing>& things, const std::vector<std::size_t>& given_to) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < things.size(); ++k) {
    if (given_to[k] == k) order.push_back(k);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const bool a_is_object = things[a].supported_by >= 0, b_is = things[b].supported_by >= 0;
    return a_is_object != b_is ? a_is_object : things[a].node_count > things[b].node_count;
  });
  std::vector<std::int32_t> place(things.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<std::int32_t>(k);
  std::vector<SegmentedThing> kept;
  for (std::size_t k : order) {
    SegmentedThing& thing = kept.emplace_back(std::move(things[k]));
    if (thing.rests_on < 0) continue;
    const std::size_t below = given_to[static_cast<std::size_t>(thing.rests_on)];
    thing.rests_on = below == k ? -1 : place[below];
  }
  things = std::move(kept);
}

}  // namespace

void GiveThings(std::vector<std::size_t> given_to, std::vector<SegmentedThing>& things) {
  for (std::size_t k = 0; k < things.size(); ++k) {
    while (given_to[given_to[k]] != given_to[k]) given_to[k] = given_to[given_to[k]];
    if (given_to[k] == k) continue;
    std::vector<std::uint32_t>& all = things[given_to[k]].points;
    all.insert(all.end(), things[k].points.begin(), things[k].points.end());
    std::ranges::sort(all);
    things[given_to[k]].node_count += things[k].node_count;
  }
  Tidy(things, given_to);
}

}  // namespace cwm::perception
