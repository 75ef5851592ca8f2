// Versions of the libraries behind the engines.
#pragma once

#include <string>

#include "collision/engines/engine.h"

namespace cwm::collision {

// The library's own version string, e.g. "0.7.0" for FCL. Empty for the exact kernels, which are
// part of this project.
std::string EngineVersion(EngineKind kind);

}  // namespace cwm::collision
