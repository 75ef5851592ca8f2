// What an occluder cuts off may stand out from another object, as a handle does: it is given back to
// the solid that it continues.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Proposes nothing where not all was seen from one place.
std::unique_ptr<const RefinementPass> MakeReturnHandles();

}  // namespace cwm::perception
