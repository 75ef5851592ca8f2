// The obstacles that a query tests: all objects and robots except the ignored ones, the querying
// one and its attached objects. Only parts of the chosen representation count, also those of a
// querying or attached object. All parts of robots and all shapes sent with the query count.
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "collision/query/query.h"

namespace cwm::collision {

class WorldFilter {
 public:
  // The filter of a query about a body. Unknown names have no effect.
  WorldFilter(const WorldSnapshot& world, const QueryOptions& options, const QueryBody& body);
  // The filter of rays and points.
  WorldFilter(const WorldSnapshot& world, const QueryOptions& options);

  bool Skips(const Obstacle& obstacle) const {
    if (skips_unseen_ && IsUnseen(obstacle)) return true;
    if (skipped_.size() > kMaxLinearSearch) {
      return std::binary_search(skipped_.begin(), skipped_.end(), &obstacle, std::less<>());
    }
    return std::find(skipped_.begin(), skipped_.end(), &obstacle) != skipped_.end();
  }
  bool SkipsPart(const Obstacle& obstacle, PartSource source) const {
    return obstacle.robot == nullptr && Skips(source);
  }
  // The same for a part of the body in the given frame.
  bool SkipsPart(const QueryBody& body, int frame, PartSource source) const {
    return body.IsObjectFrame(frame) && Skips(source);
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

  static constexpr std::size_t kMaxLinearSearch = 16;  // up to this size a linear search is fastest
  std::vector<const Obstacle*> skipped_;               // sorted by address
  Representation representation_;
  bool skips_unseen_;
};

}  // namespace cwm::collision
