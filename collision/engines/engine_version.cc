#include "collision/engines/engine_version.h"

#include <LinearMath/btScalar.h>
#include <fcl/config.h>

namespace cwm::collision {

std::string EngineVersion(EngineKind kind) {
  switch (kind) {
    case EngineKind::kExact:
      return "";
    case EngineKind::kFcl:
      return FCL_VERSION;
    case EngineKind::kBullet: {
      // 324 is 3.24.
      const int version = btGetVersion();
      return std::to_string(version / 100) + "." + std::to_string(version % 100);
    }
  }
  return "";
}

}  // namespace cwm::collision
