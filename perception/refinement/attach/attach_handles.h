// Handles that were cut off from their vessels: where the ends of a handle are hidden, nothing of
// the measured surface joins it to the wall, and it became a hypothesis of its own, or a part of one
// that touches it.
#pragma once

#include <vector>

#include "perception/refinement/attach/attachment.h"

namespace cwm::perception {

inline constexpr std::string_view kAttachHandles = "attach.handles";

struct FoundHandles {
  std::vector<Gift> gifts;
  bool all_looked_at =
      true;  // false: too many hypotheses touch to look for parts of handles in all
};

// Finds hypotheses that are handles of another one's wall of revolution (model/vessel_handles.h) and do
// not stand on a support themselves; of hypotheses that hold more than a handle, its points alone, or
// all where the rest lies on the wall too.
FoundHandles FindCutOffHandles(const SceneState& state, const Work& work);

}  // namespace cwm::perception
