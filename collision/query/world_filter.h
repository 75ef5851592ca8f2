// What of the world a question counts: objects and robots but the ignored ones and the one that
// asks with what it carries, parts of the chosen representation. Of what asks, parts of objects are
// chosen likewise. Of a robot all parts count, and all shapes that were sent.
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "collision/query/query.h"

namespace cwm::collision {

class WorldFilter {
 public:
  // Of a body that asks. Names of nothing have no effect.
  WorldFilter(const WorldSnapshot& world, const QueryOptions& options, const QueryBody& body);
  // Of rays and points.
  WorldFilter(const WorldSnapshot& world, const QueryOptions& options);

  bool Skips(const Obstacle& obstacle) const {
    if (skips_unseen_ && IsUnseen(obstacle)) return true;
    if (skipped_.size() > kFew) {
      return std::binary_search(skipped_.begin(), skipped_.end(), &obstacle, std::less<>());
    }
    return std::find(skipped_.begin(), skipped_.end(), &obstacle) != skipped_.end();
  }
  bool SkipsPart(const Obstacle& obstacle, PartSource source) const {
    return obstacle.robot == nullptr && Skips(source);
  }
  // Likewise of a part of the body in the frame.
  bool SkipsPart(const QueryBody& body, int frame, PartSource source) const {
    return body.IsOfObject(frame) && Skips(source);
  }

 private:
  void Skip(const WorldSnapshot& world, const std::string& name);
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

  static constexpr std::size_t kFew = 16;  // of which a linear search costs least
  std::vector<const Obstacle*> skipped_;   // by address
  Representation representation_;
  bool skips_unseen_;
};

}  // namespace cwm::collision
