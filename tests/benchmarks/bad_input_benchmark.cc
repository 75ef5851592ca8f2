// Clouds that no scene makes: none may take much longer than a good one of its size.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "perception/interpret_scene.h"
#include "perception/simulation/random_draws.h"
#include "perception/simulation/scenes.h"
#include "perception/simulation/unorganised.h"
#include "perception/simulation/virtual_scanner.h"
#include "tests/benchmarks/benchmarks.h"

namespace cwm::benchmarks {
namespace {

using perception::PointCloud;
using perception::RandomDraws;

constexpr int kWidth = 1280, kHeight = 960;  // of the good cloud: four Kinects
constexpr double kSigma_m = 0.003;           // of the points that are not exact

struct BadCloud {
  std::string name;
  std::function<Vector3(RandomDraws&)> draw;  // one point, in the sensor's frame: z ahead, y down
};

Vector3 Noise(RandomDraws& draws, double sigma_m) {
  return sigma_m * Vector3(draws.Normal(), draws.Normal(), draws.Normal());
}

Vector3 OnSphere(RandomDraws& draws, double radius_m) {
  return radius_m * Noise(draws, 1).normalized();
}

// One of a thousand places, always the same.
Vector3 Place(RandomDraws& draws) {
  RandomDraws place(7, static_cast<std::uint64_t>(draws.Below(1000)));
  return Vector3(0, 0, 1.5) + Vector3(place.Uniform(-1, 1), place.Uniform(-1, 1), place.Uniform());
}

const std::vector<BadCloud>& BadClouds() {
  static const std::vector<BadCloud> clouds = {
      {"one place", [](RandomDraws&) { return Vector3(0.1, 0.2, 1.5); }},
      {"a thousand places", Place},
      {"a line", [](RandomDraws& d) { return Vector3(d.Uniform(-1, 1), 0.3, 1.5); }},
      {"a noisy line",
       [](RandomDraws& d) {
         return Vector3(Vector3(d.Uniform(-1, 1), 0.3, 1.5) + Noise(d, kSigma_m));
       }},
      {"a level plane",
       [](RandomDraws& d) { return Vector3(d.Uniform(-1, 1), 0.7, d.Uniform(1, 3)); }},
      {"a noisy wall that fills the view",
       [](RandomDraws& d) {
         return Vector3(Vector3(d.Uniform(-1, 1), d.Uniform(-1, 1), 1.5) + Noise(d, kSigma_m));
       }},
      {"a sphere", [](RandomDraws& d) { return Vector3(Vector3(0, 0, 1.5) + OnSphere(d, 0.4)); }},
      {"a noisy sphere",
       [](RandomDraws& d) {
         return Vector3(Vector3(0, 0, 1.5) + OnSphere(d, 0.4) + Noise(d, kSigma_m));
       }},
      {"a thousand balls in the air",
       [](RandomDraws& d) { return Vector3(Place(d) + OnSphere(d, 0.03)); }},
      {"waves",
       [](RandomDraws& d) {
         const double x = d.Uniform(-1, 1), z = d.Uniform(1, 3);
         const double height_m = 0.1 * std::sin(20 * x) * std::cos(20 * z);
         return Vector3(Vector3(x, 0.6 + height_m, z) + Noise(d, kSigma_m));
       }},
      {"a staircase of two hundred steps",
       [](RandomDraws& d) {
         const double z = d.Uniform(1, 3);
         return Vector3(d.Uniform(-1, 1), 0.8 - std::floor((z - 1) * 100) / 100, z);
       }},
      {"noise that fills a room",
       [](RandomDraws& d) { return Vector3(d.Uniform(-1, 1), d.Uniform(-1, 1), d.Uniform(1, 3)); }},
      {"noise over a kilometre",
       [](RandomDraws& d) {
         return Vector3(d.Uniform(-500, 500), d.Uniform(-500, 500), d.Uniform(0, 1000));
       }},
  };
  return clouds;
}

PointCloud Draw(const BadCloud& bad, std::size_t count) {
  RandomDraws draws(1, 0);
  PointCloud cloud;
  cloud.points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) cloud.points.push_back(bad.draw(draws).cast<float>());
  cloud.width = static_cast<int>(count);
  return cloud;
}

// Eight things on a table.
perception::SimulatedCloud GoodImage() {
  perception::PinholeCamera camera = perception::KitchenCamera();
  camera.focal_px *= static_cast<double>(kWidth) / camera.width;
  camera.width = kWidth;
  camera.height = kHeight;
  camera.center_x_px = 0.5 * (kWidth - 1);
  camera.center_y_px = 0.5 * (kHeight - 1);
  return Scan(perception::RandomTable(1, 8), camera, {.seed = 1});
}

// Of all threads: what counts where others share the machine.
double CpuSecondsOf(const PointCloud& cloud) {
  const std::clock_t start = std::clock();
  // A refusal is an answer, and must not take longer either.
  (void)perception::InterpretScene(cloud, {}).ok();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

}  // namespace

void MeasureBadInput(Report& report) {
  const PointCloud good = perception::Shuffled(GoodImage(), 1).cloud;
  const double good_s = std::max(CpuSecondsOf(good), 1e-3);
  char text[160];
  std::snprintf(text, sizeof(text),
                "InterpretScene of %zu points in any order, two threads, CPU time over that of "
                "eight things on a table (%.2f s):",
                good.size(), good_s);
  report.Detail(text);
  double worst = 0;
  for (const BadCloud& bad : BadClouds()) {
    const double ratio = CpuSecondsOf(Draw(bad, good.size())) / good_s;
    std::snprintf(text, sizeof(text), "  %-34s %6.2f", bad.name.c_str(), ratio);
    report.Detail(text);
    worst = std::max(worst, ratio);
  }
  report.Add({.key = "bad_input_ratio",
              .value = worst,
              .unit = "1",
              .how = "CPU time of the slowest of " + std::to_string(BadClouds().size()) +
                     " clouds that no scene makes, over that of a good one of as many points"});
}

}  // namespace cwm::benchmarks
