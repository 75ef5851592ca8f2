// The known bodies of a world as a live view shows them.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "collision/geometry/hybrid_model.h"

namespace cwm::perception {

// A number that names a body for as long as it exists, whatever its pose. kNoBody: none.
using BodyId = std::uint16_t;
inline constexpr BodyId kNoBody = std::numeric_limits<BodyId>::max();

struct KnownBody {
  enum class Kind : std::uint8_t { kSupport, kObject, kResidual, kMover, kUser, kCarried };

  BodyId id = kNoBody;
  Kind kind = Kind::kObject;
  std::string name = {};
  Pose X_WB = Pose::Identity();
  std::shared_ptr<const HybridModel> model = nullptr;  // not null; compared by address

  // True if a frame may move or remove it: neither a user's, nor carried, nor a mover.
  bool IsFollowed() const {
    return kind == Kind::kSupport || kind == Kind::kObject || kind == Kind::kResidual;
  }
};

}  // namespace cwm::perception
