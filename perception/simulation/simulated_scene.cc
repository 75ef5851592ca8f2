#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

Aabb BoundsInWorld(const SimulatedObject& object) {
  Aabb bounds;
  for (const Placed<>& part : object.parts) {
    bounds.extend(TightBounds(part.shape, object.X_WO * part.X_FS));
  }
  return bounds;
}

}  // namespace cwm::perception
