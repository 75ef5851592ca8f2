// A world of 30 primitives on one square metre, and poses to query it at.
#pragma once

#include <memory>
#include <vector>

#include "collision/world/world_snapshot.h"

namespace cwm::benchmarks {

// Boxes, cylinders, spheres and capsules of 4 to 20 cm in turn; always the same ones.
std::vector<Placed<>> BenchmarkShapes();
std::shared_ptr<const collision::WorldSnapshot> MakeBenchmarkWorld();

// The same shapes repeated with the same density, on a square as large as `count` needs.
std::shared_ptr<const collision::WorldSnapshot> MakeLargeWorld(int count);

// Poses uniform over the same space, in any orientation.
std::vector<Pose> RandomPoses(int count, unsigned seed);

}  // namespace cwm::benchmarks
