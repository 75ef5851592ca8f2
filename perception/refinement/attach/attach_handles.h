// Attaches handles that were cut off from their vessels: if the ends of a handle are hidden, no
// measured surface connects it to the wall, so it becomes a hypothesis of its own, or a part of one
// that touches it.
#pragma once

#include <vector>

#include "perception/refinement/attach/attachment.h"

namespace cwm::perception {

inline constexpr std::string_view kAttachHandles = "attach.handles";

struct FoundHandles {
  std::vector<PointTransfer> transfers;
  bool all_searched = true;  // false: too many hypotheses touch to search each for parts of handles
};

// Finds hypotheses that are handles of another one's wall of revolution (handles/vessel_handles.h)
// and do not stand on that one's support. If a hypothesis has more points than those of a handle,
// only the handle's points are given, or all if the others are on the wall too.
FoundHandles FindCutOffHandles(const SceneState& state, const Work& work);

}  // namespace cwm::perception
