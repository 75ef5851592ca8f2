#include "perception/simulation/random_scenes.h"

#include "perception/simulation/kitchen_scenes.h"
#include "perception/simulation/table_scenes.h"
#include "perception/simulation/touching_scenes.h"

namespace cwm::perception {

SimulatedView RandomScene(SceneFamily family, std::uint64_t seed) {
  switch (family) {
    case SceneFamily::kTable:
      return RandomTableView(seed);
    case SceneFamily::kClutter:
      return RandomClutterView(seed);
    case SceneFamily::kKitchen:
      return RandomKitchenView(seed);
    case SceneFamily::kVessels:
      return RandomVesselView(seed);
    case SceneFamily::kStacks:
      return RandomStackView(seed);
    case SceneFamily::kHeaps:
      return RandomHeapView(seed);
    case SceneFamily::kRows:
      return RandomRowView(seed);
    case SceneFamily::kLids:
      return RandomLidView(seed);
    case SceneFamily::kEdges:
      return RandomEdgeView(seed);
    case SceneFamily::kContainers:
      return RandomContainerView(seed);
  }
  return RandomTableView(seed);
}

}  // namespace cwm::perception
