// The index of an obstacle in its snapshot, which identifies it in columns.
#pragma once

#include <cstdint>
#include <unordered_map>

#include "collision/world/world_snapshot.h"

namespace cwm::collision {

// A cache for one thread, which looks up each obstacle once.
class ObjectRanks {
 public:
  explicit ObjectRanks(const WorldSnapshot& world) : world_(world) {}

  // The index for WorldSnapshot::ObstacleAt, -1 for nullptr. The obstacle belongs to the snapshot.
  std::int32_t IndexOf(const Obstacle* object) {
    if (object == nullptr) return -1;
    if (object == last_) return last_rank_;
    const auto [at, is_new] = ranks_.try_emplace(object, 0);
    if (is_new) at->second = static_cast<std::int32_t>(world_.IndexOf(*object));
    last_ = object;
    last_rank_ = at->second;
    return last_rank_;
  }

 private:
  const WorldSnapshot& world_;
  std::unordered_map<const Obstacle*, std::int32_t> ranks_;
  const Obstacle* last_ = nullptr;
  std::int32_t last_rank_ = -1;
};

}  // namespace cwm::collision
