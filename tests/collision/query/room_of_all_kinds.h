// A room with shapes of all kinds for the tests of points, and the oracle: all parts, one after the
// other.
#pragma once

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "collision/query/query.h"
#include "tests/collision/query/random_world.h"

namespace cwm::collision {

// derived: both sides round coordinates of a few metres some dozen times.
inline constexpr double kRounding_m = 1e-13;

inline VesselShell Cup() {
  return {.outer = {{0.03, -0.05}, {0.035, 0}, {0.04, 0.05}},
          .inner = {{0.037, 0.05}, {0.032, 0}, {0.027, -0.045}, {0, -0.046}},
          .wall_thickness_m = 0.003};
}

inline Change PutCup(const std::string& name, const Pose& X_WO) {
  auto model = std::make_shared<HybridModel>();
  auto shell = std::make_shared<const VesselShell>(Cup());
  model->shapes.push_back({.X_OS = MakeTranslation(0.01, 0, 0),
                           .shape = MakeMesh(Tessellate(*shell, 1e-4)),
                           .vessel = shell});
  PutObject put;
  put.name = name;
  put.X_WO = X_WO;
  put.geometry = Prepare(std::move(model));
  return {.what = std::move(put), .expected_object_revision = {}};
}

// Two of each kind of the catalogue, two vessels and a tilted floor.
inline std::vector<Change> RoomOfAllKinds(std::mt19937& random) {
  std::vector<Change> changes;
  for (std::size_t i = 0; i < 2 * Catalogue().size(); ++i) {
    const CatalogueShape& entry = Catalogue()[i % Catalogue().size()];
    if (KindOf(entry.shape) == ShapeKind::kHalfSpace) continue;
    std::vector<Placed<>> parts = {{.X_FS = RandomPose(random, 0.05), .shape = entry.shape}};
    if (i % 3 == 0) parts.push_back({.X_FS = RandomPose(random, 0.1), .shape = Sphere{0.03}});
    changes.push_back(PutOf("object" + std::to_string(i), parts, RandomPose(random, 0.5)));
  }
  changes.push_back(PutCup("cup0", RandomPose(random, 0.5)));
  changes.push_back(PutCup("cup1", RandomPose(random, 0.5)));
  const Quaternion tilt(Eigen::AngleAxisd(0.1, Vector3::UnitX()));
  changes.push_back(PutOf("floor", {{.X_FS = Pose::Identity(), .shape = HalfSpace{}}},
                          MakePose({0, 0, -0.6}, tilt)));
  return changes;
}

inline std::vector<Vector3> RandomPoints(int count, std::mt19937& random, double spread_m = 0.7) {
  std::uniform_real_distribution<double> place(-spread_m, spread_m);
  std::vector<Vector3> points;
  for (int i = 0; i < count; ++i) {
    const double x = place(random), y = place(random), z = place(random);
    points.emplace_back(x, y, z);
  }
  return points;
}

struct Plain {
  double distance_m = std::numeric_limits<double>::infinity();
  int object = -1, part = -1;
};

inline double PartDistance_m(const WorldObject& object, std::size_t k, const Vector3& p_W) {
  const PreparedPart& part = object.geometry->parts[k];
  const Vector3 p = (object.X_WO * part.X_OP).inverse() * p_W;
  if (part.source == PartSource::kShape) {
    return SignedDistance_m(object.model().shapes[static_cast<std::size_t>(part.index)], p);
  }
  return SignedDistance_m(part.shape, p);
}

inline Plain PlainLoop(const WorldSnapshot& world, const Vector3& p_W) {
  Plain nearest;
  for (std::size_t i = 0; i < world.objects().size(); ++i) {
    const WorldObject& object = *world.objects()[i];
    for (std::size_t k = 0; k < object.geometry->parts.size(); ++k) {
      const double distance_m = PartDistance_m(object, k, p_W);
      if (distance_m >= nearest.distance_m) continue;
      nearest = {distance_m, static_cast<int>(i), static_cast<int>(k)};
    }
  }
  return nearest;
}

inline PointColumns SampleOne(const WorldSnapshot& world, const Vector3& p,
                              const QueryOptions& options = {}) {
  return *SamplePoints(world, std::vector<Vector3>{p}, options);
}

inline Vector3 GradientOf(const PointColumns& columns, std::size_t row) {
  return Vector3(&columns.gradient[3 * row]);
}

class SamplePointsTest : public ::testing::Test {
 protected:
  std::mt19937 random_{42};
  std::vector<Change> changes_ = RoomOfAllKinds(random_);
  std::shared_ptr<const WorldSnapshot> world_ = WorldOf(changes_);
  std::vector<Vector3> points_ = RandomPoints(5000, random_);
};

}  // namespace cwm::collision
