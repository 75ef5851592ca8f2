// What a snapshot or an object costs in memory, to the nearest factor of two: for the caps on
// history. Cheap: counts parts and triangles, touches no geometry.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "collision/world/world_snapshot.h"

namespace cwm::server {

// The object with all its geometry.
std::int64_t ApproximateBytes(const collision::WorldObject& object);
// The object that it will be.
std::int64_t ApproximateBytes(const collision::PutObject& put);
std::int64_t ApproximateBytes(const collision::RobotGeometry& robot);
// Triangles and vertices of all meshes together; a mesh that several parts share counts once.
struct MeshTotals {
  std::int64_t triangles = 0;
  std::int64_t vertices = 0;
};
// Geometry that is prepared from so many parts and their meshes.
std::int64_t ApproximatePreparedBytes(std::int64_t parts, const MeshTotals& meshes);

// The snapshot itself: pointers and tree, without the objects, which snapshots share.
std::int64_t ApproximateOwnBytes(const collision::WorldSnapshot& snapshot);
// What it does not share with the one before, which it differs from in so many objects.
std::int64_t ApproximateOwnBytes(const collision::WorldSnapshot& snapshot,
                                 std::size_t changed_objects);

// What a revision took out of the world: memory that from then on history alone holds. An object
// that only moved shares its geometry with its successor and counts without it.
std::int64_t ApproximateSupersededBytes(std::span<const collision::ObjectDelta> deltas);
// A robot that only moved shares its model and geometry likewise.
std::int64_t ApproximateSupersededBytes(std::span<const collision::RobotDelta> deltas);

// All of them, with their names.
std::int64_t ApproximateBytes(const collision::PairRules& rules);
std::int64_t ApproximateBytes(std::span<const collision::PairRuleDelta> deltas);

}  // namespace cwm::server
