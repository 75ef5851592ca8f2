// The memory of snapshots and objects, right within a factor of two, for the limits of the history.
// Cheap: counts parts and triangles without touching the geometry.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "collision/world/world_snapshot.h"

namespace cwm::server {

// Bytes of the object with all its geometry.
std::int64_t ApproximateBytes(const collision::WorldObject& object);
// Bytes of the object that the change makes.
std::int64_t ApproximateBytes(const collision::PutObject& put);
std::int64_t ApproximateBytes(const collision::RobotGeometry& robot);
// Triangles and vertices of all meshes together; a mesh that several parts share counts once.
struct MeshTotals {
  std::int64_t triangles = 0;
  std::int64_t vertices = 0;
};
// Bytes of geometry prepared from `parts` parts and their meshes.
std::int64_t ApproximatePreparedBytes(std::int64_t parts, const MeshTotals& meshes);

// Bytes of the snapshot itself: pointers and tree, without the objects, which snapshots share.
std::int64_t ApproximateOwnBytes(const collision::WorldSnapshot& snapshot);
// Bytes that the snapshot does not share with the previous one, from which it differs in
// `changed_objects` objects.
std::int64_t ApproximateOwnBytes(const collision::WorldSnapshot& snapshot,
                                 std::size_t changed_objects);

// Bytes that a revision took out of the world and that only the history holds from then on. An
// object that only moved shares its geometry with its successor, so its geometry does not count.
std::int64_t ApproximateSupersededBytes(std::span<const collision::ObjectDelta> deltas);
// Likewise, a robot that only moved shares its model and geometry.
std::int64_t ApproximateSupersededBytes(std::span<const collision::RobotDelta> deltas);

// Bytes of all rules with their names.
std::int64_t ApproximateBytes(const collision::PairRules& rules);
std::int64_t ApproximateBytes(std::span<const collision::PairRuleDelta> deltas);

}  // namespace cwm::server
