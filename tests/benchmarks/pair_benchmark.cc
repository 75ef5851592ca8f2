// The cost of one pair of shapes in one engine, the narrow phase. Name:
// Distance/ENGINE/KIND_A/KIND_B.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdio>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "collision/engines/engine.h"
#include "tests/benchmarks/benchmark_world.h"
#include "tests/benchmarks/benchmarks.h"

namespace cwm::benchmarks {
namespace {

using collision::Engine;
using collision::EngineKind;
using collision::QueryKind;

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
        if (a.index() > b.index() || !engine.Supports(KindOf(a), KindOf(b), QueryKind::kDistance))
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

// Microseconds per distance, over the pairs that the engine answers.
double MeanPair_us(const Engine& engine, int& pair_count) {
  const std::vector<Pose> poses = RandomPoses(2000, 3);
  double total_us = 0;
  pair_count = 0;
  for (const Shape& a : TwentyCentimetreShapes()) {
    for (const Shape& b : TwentyCentimetreShapes()) {
      if (a.index() > b.index() || !engine.Supports(KindOf(a), KindOf(b), QueryKind::kDistance)) {
        continue;
      }
      const auto geometry_a = engine.Prepare(a), geometry_b = engine.Prepare(b);
      const auto start = std::chrono::steady_clock::now();
      for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
        benchmark::DoNotOptimize(engine.Distance({KindOf(a), *geometry_a, poses[i]},
                                                 {KindOf(b), *geometry_b, poses[i + 1]},
                                                 std::numeric_limits<double>::infinity()));
      }
      const std::chrono::duration<double, std::micro> elapsed =
          std::chrono::steady_clock::now() - start;
      total_us += elapsed.count() / static_cast<double>(poses.size() - 1);
      ++pair_count;
    }
  }
  return total_us / pair_count;
}

}  // namespace

void MeasurePairs(Report& report) {
  report.Detail("Distance of a pair of 20 cm shapes, mean over the kinds:");
  double exact_us = 0, fcl_us = 0;
  int pair_count = 0;
  for (const EngineKind kind : {EngineKind::kExact, EngineKind::kFcl, EngineKind::kBullet}) {
    const double mean_us = MeanPair_us(collision::GetEngine(kind), pair_count);
    char text[96];
    std::snprintf(text, sizeof(text), "  %-7s %8.2f us (%d pairs)",
                  std::string(NameOf(kind)).c_str(), mean_us, pair_count);
    report.Detail(text);
    if (kind == EngineKind::kExact) exact_us = mean_us;
    if (kind == EngineKind::kFcl) fcl_us = mean_us;
  }
  report.Add({.key = "pair_us",
              .value = exact_us,
              .unit = "us",
              .baseline = "FCL engine",
              .baseline_value = fcl_us,
              .ratio = fcl_us / exact_us,
              .how = "mean over 15 pairs of sphere, box, cylinder, cone, capsule at random poses"});
}

}  // namespace cwm::benchmarks
