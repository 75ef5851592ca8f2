// A world with every shape, for tests of file formats.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "collision/world/world_snapshot.h"

namespace cwm::server {

// Poses are converted to quaternions and back.
inline constexpr double kRounding_m = 1e-12;

inline double DistanceInObject(const collision::WorldObject& object, const Vector3& p_W) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const auto& part : object.geometry->parts) {
    const Vector3 p = (object.X_WO * part.X_OP).inverse() * p_W;
    nearest_m = std::min(nearest_m, SignedDistance_m(part.shape, p));
  }
  return nearest_m;
}

inline TriangleMesh Tetrahedron() {
  return {.vertices = {{0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}, {0, 0, 1.0 / 3}},
          .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

struct Case {
  std::string name;
  Shape shape;
  double tolerance_m;
};

inline std::vector<Case> Cases() {
  const Polygon square = {{0.1, 0}, {0.5, 0.3}, {0.2, 0.7}, {-0.2, 0.4}};  // rotated by atan(3/4)
  const Polygon hole = {{0.1, 0.3}, {0.2, 0.3}, {0.15, 0.4}};
  const Polygon crooked = {{0, 0}, {1, 0}, {1, 1}, {0, 1.01}};
  const double round_m = kDefaultDeviation_m + kRounding_m;
  const auto hull = std::make_shared<const TriangleMesh>(Tetrahedron());
  return {{"Sphere", Sphere{0.1}, kRounding_m},
          {"Box", Box{{0.1, 0.2, 1.0 / 3}}, kRounding_m},
          {"Cylinder", Cylinder{0.1, 0.3}, kRounding_m},
          {"ConeUp", Cone{0.2, 0, 0.3}, kRounding_m},
          {"ConeDown", Cone{0, 0.2, 0.3}, kRounding_m},
          {"ConeStraight", Cone{0.2, 0.2, 0.3}, kRounding_m},
          {"Cup", Cone{0.1, 0.2, 0.3}, round_m},
          {"Capsule", Capsule{0.1, 0.3}, round_m},
          {"HalfSpace", HalfSpace{}, kRounding_m},
          {"Square", Plate{square, {}, 0.02}, kRounding_m},
          {"WithHole", Plate{square, {hole}, 0.02}, kRounding_m},
          {"Crooked", Plate{crooked, {}, 0.02}, kRounding_m},
          {"Convex", Convex{hull}, kRounding_m},
          {"Mesh", MakeMesh(Tetrahedron()), kRounding_m}};
}

// Each case as an object of one part whose pose is the object's, and as one of two parts.
inline std::shared_ptr<const collision::WorldSnapshot> WorldOfAll() {
  const Pose X_WO = MakePose({0.1, -0.2, 1.0 / 3}, Quaternion(0.5, 0.1, -0.7, 0.5).normalized());
  const Pose X_OS = MakePose({0.3, 0, 0.1}, Quaternion(0.2, 0.9, 0, 0.4).normalized());
  std::vector<collision::Change> changes;
  for (const Case& c : Cases()) {
    HybridModel alone, beside;
    alone.shapes.push_back({.X_OS = Pose::Identity(), .shape = c.shape, .fit = {}});
    beside.shapes.push_back({.X_OS = X_OS, .shape = c.shape, .fit = {}});
    beside.shapes.push_back({.X_OS = Pose::Identity(), .shape = Sphere{0.01}, .fit = {}});
    for (auto& [name, model] : {std::pair(c.name, &alone), std::pair(c.name + ".2", &beside)}) {
      changes.push_back(
          {collision::PutObject{.name = name,
                                .X_WO = X_WO,
                                .geometry = collision::Prepare(
                                    std::make_shared<const HybridModel>(std::move(*model))),
                                .supported_by = {}},
           std::nullopt});
    }
  }
  auto world = Apply(std::make_shared<const collision::WorldSnapshot>(), changes);
  EXPECT_TRUE(world.ok()) << world.status();
  return *world;
}

}  // namespace cwm::server
