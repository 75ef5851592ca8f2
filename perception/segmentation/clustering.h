// The caller's choice of how a scene is divided into objects.
#pragma once

namespace cwm::perception {

// The pieces that stand on one support become objects of their own (kObjects), or one region of
// many shapes (kNone; paper, figure 9: clutter without prior clustering).
enum class Clustering { kObjects, kNone };

}  // namespace cwm::perception
