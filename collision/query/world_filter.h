// The obstacles that a query tests: all objects and robots, or only the named ones, except the
// ignored ones, the querying one and its attached objects. Only parts of the chosen representation
// count, also those of a querying or attached object. All shapes sent with the query count, and all
// parts of robots or those of the named links.
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
    if (is_restricted_ && FindNamed(obstacle) == nullptr) return true;
    if (skipped_.size() > kMaxLinearSearch) {
      return std::binary_search(skipped_.begin(), skipped_.end(), &obstacle, std::less<>());
    }
    return std::find(skipped_.begin(), skipped_.end(), &obstacle) != skipped_.end();
  }
  // True if the part does not count, of an obstacle that does.
  bool SkipsPart(const Obstacle& obstacle, std::size_t part) const {
    if (obstacle.robot == nullptr) return Skips(obstacle.geometry->parts[part].source);
    return is_restricted_ && SkipsLink(obstacle, obstacle.robot->link_of_part[part]);
  }
  // The same for a part of the body in the given frame.
  bool SkipsPart(const QueryBody& body, int frame, PartSource source) const {
    return body.IsObjectFrame(frame) && Skips(source);
  }

 private:
  // An obstacle that QueryOptions::only names.
  struct NamedObstacle {
    const Obstacle* obstacle;
    std::vector<bool> links;  // of a robot, by index: true if the link counts; empty: all do
  };

  void Skip(const WorldSnapshot& world, const std::string& name);
  // Adds to the obstacles to which the query is restricted.
  void Restrict(const WorldSnapshot& world, const NamedThing& to);
  const NamedObstacle* FindNamed(const Obstacle& obstacle) const;
  bool SkipsLink(const Obstacle& obstacle, int link) const;
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
  bool is_restricted_ = false;                         // to `named_`
  std::vector<NamedObstacle> named_;                   // sorted by address
  Representation representation_;
  bool skips_unseen_;
};

}  // namespace cwm::collision
