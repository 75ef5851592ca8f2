// Versions of the libraries behind the engines.
#pragma once

#include <string>

#include "collision/engines/engine.h"

namespace cwm::collision {

// As the library names itself, e.g. "0.7.0" for FCL; empty for the exact kernels, which are our
// own.
std::string EngineVersion(EngineKind kind);

}  // namespace cwm::collision
