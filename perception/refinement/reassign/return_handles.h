// Returns handles to the solid that they continue: a part of it behind an occluder may seem to
// stand out from another object, like a handle.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Proposes nothing if not all points were seen from one place.
std::unique_ptr<const RefinementPass> MakeReturnHandles();

}  // namespace cwm::perception
