#include "perception/order_things.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>

namespace cwm::perception {

std::size_t CountObjects(const SegmentedScene& scene) {
  const auto end = std::ranges::find_if(
      scene.things, [](const SegmentedThing& thing) { return thing.supported_by < 0; });
  return static_cast<std::size_t>(end - scene.things.begin());
}

void StandAsModelled(const std::vector<ModelledThing>& modelled, SegmentedScene& scene) {
  for (std::size_t k = 0; k < modelled.size(); ++k) {
    if (modelled[k].reaches_support)
      scene.things[k].foot_height_m = 0, scene.things[k].rests_on = -1;
  }
}

void SortBySize(SegmentedScene& scene, std::vector<ModelledThing>& modelled) {
  std::vector<std::size_t> order(scene.things.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(CountObjects(scene)),
                   [&](std::size_t a, std::size_t b) {
                     return scene.things[a].node_count > scene.things[b].node_count;
                   });
  std::vector<std::int32_t> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<std::int32_t>(k);
  std::vector<SegmentedThing> sorted;
  std::vector<ModelledThing> sorted_models;
  for (std::size_t k : order) {
    SegmentedThing& thing = sorted.emplace_back(std::move(scene.things[k]));
    if (thing.rests_on >= 0) thing.rests_on = place[static_cast<std::size_t>(thing.rests_on)];
    sorted_models.push_back(std::move(modelled[k]));
  }
  scene.things = std::move(sorted);
  modelled = std::move(sorted_models);
}

}  // namespace cwm::perception
