// Splits off an object that touches another one: a connected part that the solids which explain
// most of the object do not explain.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// The largest connected part of an object that no closed solid explains becomes an object below, on
// or beside the rest, if it is one solid by itself that reaches its ground, and if the criterion
// prefers two objects.
std::unique_ptr<const RefinementPass> MakeSplitUnexplainedParts();

}  // namespace cwm::perception
