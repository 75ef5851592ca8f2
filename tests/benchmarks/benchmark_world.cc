#include "tests/benchmarks/benchmark_world.h"

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <utility>

namespace cwm::benchmarks {
namespace {

constexpr int kObjects = 30;

Pose RandomPose(std::mt19937_64& random) {
  std::uniform_real_distribution<double> across(-0.5, 0.5), up(0, 0.6);
  std::normal_distribution<double> normal;
  const Quaternion q(normal(random), normal(random), normal(random), normal(random));
  return MakePose({across(random), across(random), up(random)}, q.normalized());
}

}  // namespace

std::vector<Placed<>> BenchmarkShapes() {
  std::mt19937_64 random(42);
  std::uniform_real_distribution<double> size(0.04, 0.2);
  std::vector<Placed<>> shapes;
  for (int i = 0; i < kObjects; ++i) {
    const double a = size(random), b = size(random), c = size(random);
    Shape shape;
    switch (i % 4) {
      case 0:
        shape = Box{.size_m = {a, b, c}};
        break;
      case 1:
        shape = Cylinder{.radius_m = a / 2, .length_m = b};
        break;
      case 2:
        shape = Sphere{.radius_m = a / 2};
        break;
      default:
        shape = Capsule{.radius_m = a / 4, .length_m = b};
        break;
    }
    shapes.push_back({.X_FS = RandomPose(random), .shape = std::move(shape)});
  }
  return shapes;
}

std::shared_ptr<const collision::WorldSnapshot> MakeBenchmarkWorld() {
  std::vector<collision::Change> changes;
  for (const Placed<>& placed : BenchmarkShapes()) {
    auto model = std::make_shared<HybridModel>();
    model->shapes.emplace_back().shape = placed.shape;
    collision::PutObject put;
    put.name = "object_" + std::to_string(changes.size());
    put.X_WO = placed.X_FS;
    put.geometry = collision::Prepare(std::move(model));
    changes.emplace_back().what = std::move(put);
  }
  auto world = collision::Apply(std::make_shared<const collision::WorldSnapshot>(), changes);
  return world.value();
}

std::shared_ptr<const collision::WorldSnapshot> MakeLargeWorld(int count) {
  std::vector<std::shared_ptr<const collision::PreparedModel>> models;
  for (const Placed<>& placed : BenchmarkShapes()) {
    auto model = std::make_shared<HybridModel>();
    model->shapes.emplace_back().shape = placed.shape;
    models.push_back(collision::Prepare(std::move(model)));
  }
  const double half_side_m = 0.5 * std::sqrt(static_cast<double>(count) / kObjects);
  std::mt19937_64 random(43);
  std::uniform_real_distribution<double> across(-half_side_m, half_side_m);
  std::vector<collision::Change> changes;
  for (int i = 0; i < count; ++i) {
    collision::PutObject put;
    put.name = "object_" + std::to_string(i);
    put.X_WO = RandomPose(random);
    put.X_WO.translation().head<2>() = Vector2(across(random), across(random));
    put.geometry = models[static_cast<std::size_t>(i) % models.size()];
    changes.emplace_back().what = std::move(put);
  }
  return collision::Apply(std::make_shared<const collision::WorldSnapshot>(), changes).value();
}

std::vector<Pose> RandomPoses(int count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) poses.push_back(RandomPose(random));
  return poses;
}

}  // namespace cwm::benchmarks
