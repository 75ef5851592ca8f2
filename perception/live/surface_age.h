// For how long places in the world have shown a surface that nothing explains.
#pragma once

#include <cstdint>

#include "absl/container/flat_hash_map.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/world_cell.h"

namespace cwm::perception {

// A moving sensor sees what rests in other pixels from frame to frame, but in the same cells of the
// world. A cell's age begins anew when it was not seen for some frames.
class SurfaceAge {
 public:
  struct Age {
    Stamp since = {};
    Stamp last = {};
    int frames = 0;
  };

  // A frame shows a surface there. Frames come in the order of their stamps.
  const Age& See(const Vector3& p_W, Stamp stamp);
  // Forgets cells that were not seen for long; once for each frame.
  void Prune(Stamp stamp);

 private:
  absl::flat_hash_map<std::uint64_t, Age> cells_;
  Stamp pruned_ = {};
};

}  // namespace cwm::perception
