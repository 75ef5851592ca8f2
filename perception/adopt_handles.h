// Handles that were cut off from their vessels: where the ends of a handle are hidden, nothing of
// the measured surface joins it to the wall, and it became a thing of its own, or a part of one that
// touches it.
#pragma once

#include "perception/cloud/work.h"
#include "perception/scene/segment_scene.h"

namespace cwm::perception {

// Gives things that are handles of another thing's wall of revolution (model/vessel_handles.h), and
// do not stand on a support themselves, to that thing; of things that hold more than a handle, its
// points alone, or all where the rest lies on the wall too. Objects stay before residuals, largest
// first. False where there were too many things that touch to look for parts of handles in all.
bool AdoptHandles(SegmentedScene& scene, const Work& work);

}  // namespace cwm::perception
