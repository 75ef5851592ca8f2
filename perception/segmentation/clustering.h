// What a caller decides about how a scene is divided.
#pragma once

namespace cwm::perception {

// What becomes of the pieces that stand on one support: objects of their own, or one region of many
// shapes (paper, figure 9: clutter without prior clustering).
enum class Clustering { kObjects, kNone };

}  // namespace cwm::perception
