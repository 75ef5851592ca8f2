// What of the world a question counts: objects but the ignored ones and the one that asks, parts of
// the chosen representation.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "collision/query/query.h"

namespace cwm::collision {

class WorldFilter {
 public:
  // `self` may be empty. Names of no object have no effect.
  WorldFilter(const WorldSnapshot& world, const QueryOptions& options, const std::string& self);

  bool Skips(const WorldObject& object) const {
    if (skips_unseen_ && object.kind == ObjectKind::kUnseen) return true;
    return std::find(skipped_.begin(), skipped_.end(), &object) != skipped_.end();
  }
  bool Skips(PartSource source) const {
    switch (representation_) {
      case Representation::kShapes:
        return source != PartSource::kShape;
      case Representation::kSurfaces:
        return source == PartSource::kShape;
      case Representation::kHybrid:
        break;
    }
    return false;
  }

 private:
  std::vector<const WorldObject*> skipped_;  // few: a linear search costs least
  Representation representation_;
  bool skips_unseen_;
};

}  // namespace cwm::collision
