// One pair of shapes, one engine: what a narrow phase costs. Name: Distance/ENGINE/KIND_A/KIND_B.
#include <benchmark/benchmark.h>

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "collision/engines/engine.h"
#include "tests/benchmarks/benchmark_world.h"

namespace cwm::benchmarks {
namespace {

using collision::Engine;
using collision::EngineKind;
using collision::Question;

std::vector<Shape> TwentyCentimetreShapes() {
  return {Sphere{.radius_m = 0.1}, Box{.size_m = {0.2, 0.2, 0.2}},
          Cylinder{.radius_m = 0.1, .length_m = 0.2},
          Cone{.radius_bottom_m = 0.1, .radius_top_m = 0.05, .length_m = 0.2},
          Capsule{.radius_m = 0.05, .length_m = 0.1}};
}

void RunPair(benchmark::State& state, const Engine& engine, const Shape& a, const Shape& b) {
  const auto geometry_a = engine.Prepare(a);
  const auto geometry_b = engine.Prepare(b);
  const std::vector<Pose> poses = RandomPoses(256, 3);
  std::size_t i = 0;
  for (auto _ : state) {
    const Pose& X_WA = poses[i % poses.size()];
    const Pose& X_WB = poses[(i * 7 + 1) % poses.size()];
    benchmark::DoNotOptimize(engine.Distance({KindOf(a), *geometry_a, X_WA},
                                             {KindOf(b), *geometry_b, X_WB},
                                             std::numeric_limits<double>::infinity()));
    ++i;
  }
}

const bool kRegistered = [] {
  for (const EngineKind kind : {EngineKind::kExact, EngineKind::kFcl, EngineKind::kBullet}) {
    const Engine& engine = collision::GetEngine(kind);
    for (const Shape& a : TwentyCentimetreShapes()) {
      for (const Shape& b : TwentyCentimetreShapes()) {
        if (a.index() > b.index() || !engine.Supports(KindOf(a), KindOf(b), Question::kDistance))
          continue;
        const std::string name = "Distance/" + std::string(NameOf(kind)) + "/" +
                                 std::string(NameOf(KindOf(a))) + "/" +
                                 std::string(NameOf(KindOf(b)));
        benchmark::RegisterBenchmark(name.c_str(), [&engine, a, b](benchmark::State& state) {
          RunPair(state, engine, a, b);
        });
      }
    }
  }
  return true;
}();

}  // namespace
}  // namespace cwm::benchmarks
