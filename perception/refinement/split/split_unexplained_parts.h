// Solids explain most of an object, and a part that hangs together lies off them: another object that
// touches the first.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// The largest part of an object that no closed solid explains and that hangs together becomes an object
// below, on or beside the rest, where it is one solid by itself that reaches its ground, and where
// the criterion prefers two objects.
std::unique_ptr<const RefinementPass> MakeSplitUnexplainedParts();

}  // namespace cwm::perception
