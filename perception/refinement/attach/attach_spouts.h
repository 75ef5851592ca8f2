// Attaches spouts: parts that jut out of a vessel's wall and hang in the air.
#pragma once

#include <string_view>
#include <vector>

#include "perception/refinement/attach/attachment.h"

namespace cwm::perception {

inline constexpr std::string_view kAttachSpouts = "attach.spouts";

// Finds hypotheses that hang in the air, rest on no other one, and begin at the outside of another
// one's wall of revolution (handles/vessel_handles.h), below its rim: a spout, in as many pieces as
// are visible. A hypothesis with a hidden foot may stand behind the vessel instead, and is not
// attached. Returns nothing if not all points were seen from one place.
std::vector<PointTransfer> FindSpouts(const SceneState& state, const Work& work);

}  // namespace cwm::perception
