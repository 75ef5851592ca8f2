// A world of 30 primitives on one square metre, and places to ask about.
#pragma once

#include <memory>
#include <vector>

#include "collision/world/world_snapshot.h"

namespace cwm::benchmarks {

// Boxes, cylinders, spheres and capsules of 4 to 20 cm in turn; always the same ones.
std::vector<Placed<>> BenchmarkShapes();
std::shared_ptr<const collision::WorldSnapshot> MakeBenchmarkWorld();

// The same shapes over and over, as densely as there, on a square as large as `count` needs.
std::shared_ptr<const collision::WorldSnapshot> MakeLargeWorld(int count);

// Uniform over the same space, any orientation.
std::vector<Pose> RandomPoses(int count, unsigned seed);

}  // namespace cwm::benchmarks
