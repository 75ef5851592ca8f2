// Spouts: what juts out of a vessel's wall and hangs in the air.
#pragma once

#include "perception/cloud/work.h"
#include "perception/scene/segment_scene.h"

namespace cwm::perception {

// Gives things that hang in the air, rest on no other thing, and begin at the outside of another one's
// wall of revolution (model/vessel_handles.h), below its rim, to that thing: a spout in as many pieces as
// are seen of it. One whose foot is hidden may stand behind the vessel as well, and stays.
void AdoptHanging(SegmentedScene& scene, const Work& work);

}  // namespace cwm::perception
