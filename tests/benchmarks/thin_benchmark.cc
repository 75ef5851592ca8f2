// Thin things on tables, and tables without any: what is found of what rises above its support by
// four times the error of its mean height.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "perception/cloud/parallel_for.h"
#include "perception/interpret_scene.h"
#include "perception/simulation/angles.h"
#include "perception/simulation/furniture.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/random_draws.h"
#include "perception/simulation/virtual_scanner.h"
#include "tests/benchmarks/benchmarks.h"

namespace cwm::benchmarks {
namespace {

using namespace perception;

constexpr int kThinThreads = 2;
constexpr std::uint64_t kThinStream = 0x7468;
constexpr double kTableTop_m = 0.72;
constexpr int kMinPoints = 300;
constexpr double kMinHeight_errors = 4;
constexpr std::uint32_t kFirstObject = 20;  // the least label of an object

struct ThinSensor {
  std::string_view name;
  SensorNoise noise;
  // Its errors are alike over whole windows, so that the error of a mean is more than told: its
  // things are printed apart, and only its phantoms count.
  bool matches_windows = false;
};
const std::array<ThinSensor, 4>& ThinSensors() {
  static const std::array<ThinSensor, 4> sensors = {
      {{"kinect", {.model = SensorModel::kKinect}},
       {"realsense", {.model = SensorModel::kRealSense}},
       {"realsense, windows", {.model = SensorModel::kRealSense}, true},
       {"0.5 mm + 0.8 mm z^2",
        {.model = SensorModel::kGiven, .given_sigma_m = 5e-4, .given_quadratic_per_m = 8e-4}}}};
  return sensors;
}

struct ThinScene {
  SimulatedScene scene = {};
  PinholeCamera camera = {};
};

// A floor, a table and up to `count` thin things that lie on it, apart from each other.
ThinScene MakeThinScene(int count, std::uint64_t seed) {
  RandomDraws draws(seed, kThinStream);
  ThinScene made;
  const Vector2 half(draws.Uniform(0.35, 0.6), draws.Uniform(0.35, 0.6));
  made.scene.objects.push_back(
      MakeTop("floor", {.area_W = {Vector2(-3, -3), Vector2(3, 3)}, .top_m = 0}));
  made.scene.objects.push_back(MakeTop("table", {.area_W = {-half, half}, .top_m = kTableTop_m}));
  for (int i = 0; i < count; ++i) {
    const Vector3 size_m(draws.Uniform(0.06, 0.25), draws.Uniform(0.06, 0.25),
                         draws.Uniform(0.005, 0.020));
    // One to a quarter of the middle of the table, so that they do not touch.
    const Vector2 quarter(i % 2 == 0 ? -0.17 : 0.17, i / 2 % 2 == 0 ? -0.17 : 0.17);
    const Vector2 place = quarter + Vector2(draws.Uniform(-0.01, 0.01), draws.Uniform(-0.01, 0.01));
    const Quaternion turned(
        Eigen::AngleAxisd(draws.Uniform(0, 2 * std::numbers::pi), Vector3::UnitZ()));
    made.scene.objects.push_back(
        {.name = "thin",
         .parts = {{Pose::Identity(), Box{size_m}}},
         .X_WO = MakePose({place.x(), place.y(), kTableTop_m + size_m.z() / 2}, turned)});
  }
  made.camera.X_WC =
      LookAt(Vector3(0, 0, kTableTop_m),
             ViewingDirection{.distance_m = draws.Uniform(0.7, 1.1),
                              .down_rad = Radians(draws.Uniform(30, 75)),
                              .azimuth_rad = draws.Uniform(0, 2 * std::numbers::pi)});
  return made;
}

// The standard deviation of the mean height of `points` points over their support: noise, with
// kPointsPerIndependentSample neighbours that err alike, and warp.
double ErrorOfMean_m(const SensorNoise& noise, double depth_m, std::size_t points) {
  const double samples = std::max(1.0, static_cast<double>(points) / noise.PointsPerSample());
  return std::hypot(noise.AxialSigma_m(depth_m) / std::sqrt(samples), noise.WarpSigma_m());
}

struct ThinTally {
  int asked = 0, found = 0;    // things
  int bare = 0, phantoms = 0;  // tables, and objects on them
  std::vector<std::string> remarks = {};
  void Add(const ThinTally& other) {
    asked += other.asked, found += other.found;
    bare += other.bare, phantoms += other.phantoms;
    remarks.insert(remarks.end(), other.remarks.begin(), other.remarks.end());
  }
};

// True if an object has half of the thing's points or more, and is of them for a half or more.
bool IsFound(const std::vector<std::uint32_t>& labels, const std::vector<std::size_t>& points) {
  std::map<std::uint32_t, std::size_t> counts;
  for (const std::size_t i : points) {
    if (labels[i] >= kFirstObject) ++counts[labels[i] / 10];
  }
  for (const auto& entry : counts) {
    const std::uint32_t object = entry.first;
    const std::size_t count = entry.second;
    const auto all = std::ranges::count_if(
        labels, [object](std::uint32_t label) { return label / 10 == object; });
    if (2 * count >= points.size() && 2 * count >= static_cast<std::size_t>(all)) return true;
  }
  return false;
}

ThinTally JudgeThin(const ThinSensor& sensor, int count, std::uint64_t seed) {
  const SensorNoise& noise = sensor.noise;
  const ThinScene made = MakeThinScene(count, seed);
  const SimulatedCloud scan =
      Scan(made.scene, made.camera,
           {.noise = noise, .matches_windows = sensor.matches_windows, .seed = seed});
  InterpretOptions options;
  options.noise = noise;
  options.max_threads = 1;
  options.X_WC = made.camera.X_WC;
  const auto found = InterpretScene(scan.cloud, options);
  ThinTally tally;
  if (!found.ok()) return tally;
  if (count == 0) {
    tally.bare = 1;
    for (const DetectedObject& object : found->objects) {
      if (object.kind != DetectedKind::kObject) continue;
      ++tally.phantoms;
      Aabb bounds;
      for (const Eigen::Vector3f& p : object.points_L) {
        bounds.extend(Vector3(made.camera.X_WC.translation() + p.cast<double>()));
      }
      char text[160];
      std::snprintf(text, sizeof(text),
                    "seed %llu: phantom of %.0f x %.0f x %.0f mm at %.2f, %.2f, %.3f m",
                    static_cast<unsigned long long>(seed), 1000 * bounds.sizes().x(),
                    1000 * bounds.sizes().y(), 1000 * bounds.sizes().z(), bounds.center().x(),
                    bounds.center().y(), bounds.center().z());
      tally.remarks.emplace_back(text);
    }
    return tally;
  }
  std::vector<std::vector<std::size_t>> points(made.scene.objects.size());
  for (std::size_t i = 0; i < scan.object.size(); ++i) {
    if (scan.object[i] >= 0) points[static_cast<std::size_t>(scan.object[i])].push_back(i);
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    const SimulatedObject& object = made.scene.objects[k];
    if (object.is_support || points[k].size() < kMinPoints) continue;
    double depth_m = 0;
    for (const std::size_t i : points[k]) depth_m += scan.cloud.points[i].z();
    depth_m /= static_cast<double>(points[k].size());
    // Heights are measured along the rays.
    const Vector3 to_sensor = made.camera.X_WC.translation() - object.X_WO.translation();
    const double error_m =
        to_sensor.normalized().z() * ErrorOfMean_m(noise, depth_m, points[k].size());
    if (2 * (object.X_WO.translation().z() - kTableTop_m) < kMinHeight_errors * error_m) continue;
    ++tally.asked;
    if (IsFound(found->labels, points[k])) {
      ++tally.found;
      continue;
    }
    std::map<std::uint32_t, std::size_t> shares;
    for (const std::size_t i : points[k]) ++shares[found->labels[i] / 10];
    std::string of;
    for (const auto& [label, count] : shares) {
      of += ", " + std::to_string(100 * count / points[k].size()) + " % " +
            (label == 0 ? "support" : "object " + std::to_string(label - 1));
    }
    const Vector3 size_m = std::get<Box>(object.parts.front().shape).size_m;
    char text[300];
    std::snprintf(
        text, sizeof(text),
        "seed %llu: missed %.0f x %.0f x %.1f mm, %.1f errors high, %zu points at %.2f m%s",
        static_cast<unsigned long long>(seed), 1000 * size_m.x(), 1000 * size_m.y(),
        1000 * size_m.z(), size_m.z() / error_m, points[k].size(), depth_m, of.c_str());
    tally.remarks.emplace_back(text);
  }
  return tally;
}

}  // namespace

void MeasureThinOn(const Seeds& seeds, Report& report) {
  constexpr int kThings = 4;
  const auto& sensors = ThinSensors();
  const auto scenes = static_cast<std::size_t>(seeds.count);
  std::vector<ThinTally> tallies(2 * scenes * sensors.size());
  ParallelFor(
      tallies.size(), 1, {.max_threads = kThinThreads}, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          tallies[k] =
              JudgeThin(sensors[k % sensors.size()], k / sensors.size() % 2 == 0 ? kThings : 0,
                        seeds.first + k / (2 * sensors.size()));
        }
      });
  ThinTally total;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    ThinTally of_sensor;
    for (std::size_t k = s; k < tallies.size(); k += sensors.size()) of_sensor.Add(tallies[k]);
    char text[160];
    std::snprintf(text, sizeof(text),
                  "  %-20s %4d of %4d thin things; %d phantoms on %d bare tables",
                  std::string(sensors[s].name).c_str(), of_sensor.found, of_sensor.asked,
                  of_sensor.phantoms, of_sensor.bare);
    report.Detail(text);
    if (sensors[s].matches_windows) of_sensor.asked = of_sensor.found = 0;
    total.Add(of_sensor);
  }
  report.Attach("thin_things.txt", total.remarks);
  report.Add({.key = "thin_found",
              .value = static_cast<double>(total.found) / std::max(1, total.asked),
              .unit = "1",
              .how = "of " + std::to_string(total.asked) +
                     " things of 5 to 20 mm with 300 points or more whose height is four errors "
                     "of their mean or more, warp included"});
  report.Add({.key = "thin_phantoms",
              .value = 1000.0 * total.phantoms / std::max(1, total.bare),
              .unit = "per 1000 tables",
              .how = "objects on " + std::to_string(total.bare) + " bare tables"});
}

void MeasureThin(Report& report) { MeasureThinOn(kSeedsOfThin, report); }

}  // namespace cwm::benchmarks
