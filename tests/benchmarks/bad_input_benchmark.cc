// Clouds that no scene makes: none of them may take much longer than a good cloud of its size.
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

// One of a thousand places, which are always the same.
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

// Draws the range at a pixel of an image without missing returns, in metres along the optical axis.
struct BadImage {
  std::string name;
  std::function<double(RandomDraws&, double column, double row)> draw;
};

const std::vector<BadImage>& BadImages() {
  static const std::vector<BadImage> images = {
      {"an image of noise", [](RandomDraws& d, double, double) { return d.Uniform(0.5, 3); }},
      {"an image of a fleece",
       [](RandomDraws& d, double, double) { return 1 + 0.01 * d.Normal(); }},
      {"an image of smooth bumps",
       [](RandomDraws&, double column, double row) {
         return 1 + 0.02 * std::sin(column / 9) * std::sin(row / 9);
       }},
      {"an image of noisy bumps",
       [](RandomDraws& d, double column, double row) {
         return 1 + 0.05 * std::sin(column / 5) * std::sin(row / 5) + 0.002 * d.Normal();
       }},
      {"an image of steps",
       [](RandomDraws& d, double column, double row) {
         const double raised = std::fmod(std::floor(column / 16) + std::floor(row / 16), 2);
         return 1 + 0.1 * raised + 0.001 * d.Normal();
       }},
      {"an image of a wall", [](RandomDraws& d, double, double) { return 1 + 0.001 * d.Normal(); }},
  };
  return images;
}

PointCloud Draw(const BadImage& bad, const perception::PinholeCamera& camera) {
  RandomDraws draws(1, 0);
  PointCloud cloud;
  cloud.width = camera.width;
  cloud.height = camera.height;
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const Vector3 ray((column - camera.center_x_px) / camera.focal_px,
                        (row - camera.center_y_px) / camera.focal_px, 1);
      cloud.points.push_back((bad.draw(draws, column, row) * ray).cast<float>());
    }
  }
  return cloud;
}

PointCloud Draw(const BadCloud& bad, std::size_t count) {
  RandomDraws draws(1, 0);
  PointCloud cloud;
  cloud.points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) cloud.points.push_back(bad.draw(draws).cast<float>());
  cloud.width = static_cast<int>(count);
  return cloud;
}

// A scan in another unit or much farther away: noise, cell widths and object sizes no longer match.
struct ScaledScan {
  std::string name;
  float factor;
};

const std::vector<ScaledScan>& ScaledScans() {
  static const std::vector<ScaledScan> scans = {
      {"a tenth as large", 0.1F},    {"five times as large", 5},      {"ten times as large", 10},
      {"twenty times as large", 20}, {"in inches as metres", 39.37F}, {"in millimetres", 1000}};
  return scans;
}

PointCloud Draw(const ScaledScan& bad, const PointCloud& good) {
  PointCloud cloud = good;
  for (Eigen::Vector3f& point : cloud.points) point *= bad.factor;
  return cloud;
}

perception::PinholeCamera FourKinects() {
  perception::PinholeCamera camera = perception::KitchenCamera();
  camera.focal_px *= static_cast<double>(kWidth) / camera.width;
  camera.width = kWidth;
  camera.height = kHeight;
  camera.center_x_px = 0.5 * (kWidth - 1);
  camera.center_y_px = 0.5 * (kHeight - 1);
  return camera;
}

// Processor time of all threads, because the machine is shared with others.
double CpuSecondsOf(const PointCloud& cloud) {
  const std::clock_t start = std::clock();
  // A refusal is an answer, and must not take longer either.
  (void)perception::InterpretScene(cloud, {}).ok();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

// The largest ratio of the time of a bad cloud to that of a good one of the same form. A shared
// machine may be twice as fast at one time as at another, so the good cloud is measured before and
// after each bad one.
template <class Bad, class Form>
double WorstRatio(const std::vector<Bad>& all, const Form& form, const PointCloud& good,
                  Report& report) {
  (void)CpuSecondsOf(good);  // the first run includes allocating its memory
  std::vector<double> good_s = {CpuSecondsOf(good)};
  double worst = 0;
  for (const Bad& bad : all) {
    const double bad_s = CpuSecondsOf(Draw(bad, form));
    good_s.push_back(CpuSecondsOf(good));
    const double ratio = 2 * bad_s / (good_s.end()[-2] + good_s.end()[-1]);
    char text[160];
    std::snprintf(text, sizeof(text), "  %-34s %6.2f", bad.name.c_str(), ratio);
    report.Detail(text);
    worst = std::max(worst, ratio);
  }
  char text[80];
  std::snprintf(text, sizeof(text), "  the good one: %.2f s", Median(std::move(good_s)));
  report.Detail(text);
  return worst;
}

}  // namespace

void MeasureBadInput(Report& report) {
  const perception::PinholeCamera camera = FourKinects();
  const perception::SimulatedCloud good = Scan(perception::RandomTable(1, 8), camera, {.seed = 1});
  const PointCloud shuffled = perception::Shuffled(good, 1).cloud;
  const auto say = [&](const char* form, const PointCloud& cloud) {
    char text[160];
    std::snprintf(
        text, sizeof(text),
        "InterpretScene of %zu points %s, two threads, CPU time over that of eight objects "
        "on a table:",
        cloud.size(), form);
    report.Detail(text);
  };
  say("in any order", shuffled);
  const double of_clouds = WorstRatio(BadClouds(), shuffled.size(), shuffled, report);
  say("in an image", good.cloud);
  const double of_images = WorstRatio(BadImages(), camera, good.cloud, report);
  say("in an image, of another scale", good.cloud);
  const double of_scaled = WorstRatio(ScaledScans(), good.cloud, good.cloud, report);
  report.Add(
      {.key = "bad_input_ratio",
       .value = std::max({of_clouds, of_images, of_scaled}),
       .unit = "1",
       .how = "CPU time of the slowest of " +
              std::to_string(BadClouds().size() + BadImages().size() + ScaledScans().size()) +
              " clouds that no scene makes, over that of a good one of as many points"});
}

}  // namespace cwm::benchmarks
