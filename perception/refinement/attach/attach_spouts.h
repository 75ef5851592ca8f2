// Spouts: what juts out of a vessel's wall and hangs in the air.
#pragma once

#include <string_view>
#include <vector>

#include "perception/refinement/attach/attachment.h"

namespace cwm::perception {

inline constexpr std::string_view kAttachSpouts = "attach.spouts";

// Finds hypotheses that hang in the air, rest on no other one, and begin at the outside of another
// one's wall of revolution (model/vessel_handles.h), below its rim: a spout in as many pieces as are
// seen of it. One whose foot is hidden may stand behind the vessel as well, and stays. Nothing where
// not all was seen from one place.
std::vector<Gift> FindSpouts(const SceneState& state, const Work& work);

}  // namespace cwm::perception
