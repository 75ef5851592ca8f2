// Worlds and bodies for tests of queries.
#pragma once

#include <random>
#include <string>

#include "collision/query/query.h"
#include "collision/world/world_snapshot.h"
#include "tests/contract/catalogue.h"

namespace cwm::collision {

inline std::shared_ptr<const PreparedModel> ModelOf(std::vector<Placed<>> shapes) {
  return BodyFromShapes(std::move(shapes)).geometry;
}

inline Change PutOf(const std::string& name, std::vector<Placed<>> shapes, const Pose& X_WO) {
  PutObject put;
  put.name = name;
  put.X_WO = X_WO;
  put.geometry = ModelOf(std::move(shapes));
  return {.what = std::move(put), .expected_object_revision = {}};
}

inline std::shared_ptr<const WorldSnapshot> WorldOf(const std::vector<Change>& changes) {
  return *Apply(std::make_shared<const WorldSnapshot>(), changes);
}

// A world of `count` objects with the catalogue's bounded shapes; every third has two parts.
inline std::shared_ptr<const WorldSnapshot> RandomWorld(int count, std::mt19937& random,
                                                        bool with_meshes) {
  std::vector<Change> changes;
  for (int i = 0; static_cast<int>(changes.size()) < count; ++i) {
    const Shape& shape = Catalogue()[i % Catalogue().size()].shape;
    if (KindOf(shape) == ShapeKind::kHalfSpace) continue;
    if (KindOf(shape) == ShapeKind::kMesh && !with_meshes) continue;
    std::vector<Placed<>> parts = {{.X_FS = RandomPose(random, 0.05), .shape = shape}};
    if (i % 3 == 0) parts.push_back({.X_FS = RandomPose(random, 0.1), .shape = Sphere{0.03}});
    changes.push_back(
        PutOf("object" + std::to_string(i), std::move(parts), RandomPose(random, 1.0)));
  }
  return WorldOf(changes);
}

inline std::vector<Pose> RandomPoses(int count, std::mt19937& random) {
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) poses.push_back(RandomPose(random, 1.0));
  return poses;
}

// A gripper-like body: a box and a capsule.
inline QueryBody Gripper() {
  return BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Box{{0.08, 0.12, 0.05}}},
                         {.X_FS = MakeTranslation(0, 0, 0.1), .shape = Capsule{0.02, 0.1}}});
}

}  // namespace cwm::collision
