#include "tests/benchmarks/live/live_scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "perception/simulation/furniture.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/random_draws.h"

namespace cwm::benchmarks {
namespace {

using perception::RandomDraws;
using perception::SimulatedObject;

constexpr int kRows = 4, kColumns = 5;
constexpr double kRowStep_m = 0.19, kColumnStep_m = 0.2;
constexpr double kJitter_m = 0.015;  // of a thing's place in the grid
const Vector3 kMiddle(0.72, 0, kTableTop_m);

// Solids that stand on z = 0, with footprints of at most 60 mm radius.
Placed<> RandomThing(RandomDraws& draws) {
  const auto standing = [](Shape shape, double height_m) {
    return Placed<>{.X_FS = MakeTranslation(0, 0, 0.5 * height_m), .shape = std::move(shape)};
  };
  switch (draws.Below(4)) {
    case 0: {
      const double x_m = draws.Uniform(0.05, 0.1), y_m = draws.Uniform(0.04, 0.06);
      const double z_m = draws.Uniform(0.05, 0.16);
      return standing(Box{.size_m = {x_m, y_m, z_m}}, z_m);
    }
    case 1: {
      const double length_m = draws.Uniform(0.06, 0.16);
      return standing(Cylinder{.radius_m = draws.Uniform(0.027, 0.05), .length_m = length_m},
                      length_m);
    }
    case 2: {
      const double radius_m = draws.Uniform(0.032, 0.055);
      return standing(Sphere{.radius_m = radius_m}, 2 * radius_m);
    }
    default: {
      const double bottom_m = draws.Uniform(0.026, 0.034), length_m = draws.Uniform(0.07, 0.12);
      const double top_m = bottom_m + draws.Uniform(0.01, 0.02);
      return standing(
          Cone{.radius_bottom_m = bottom_m, .radius_top_m = top_m, .length_m = length_m}, length_m);
    }
  }
}

perception::SequenceSensor Sensor(int index) {
  // Eyes before the table, and to both sides of it.
  const Vector3 eyes[] = {{0.15, 0, 1.55}, {0.5, -0.7, 1.5}, {0.5, 0.7, 1.5}};
  perception::SequenceSensor sensor;
  sensor.name = "camera_" + std::to_string(index + 1);
  sensor.mount = perception::LookAt(eyes[index], kMiddle);
  sensor.device_seed = 100 + static_cast<std::uint64_t>(index);
  return sensor;
}

}  // namespace

perception::SequenceScript TableScript(const TableOptions& options) {
  perception::SequenceScript script;
  script.duration_s = options.duration_s;
  script.seed = options.seed;
  // The table fills the view, so that rays are as long as those of a camera over a work space.
  script.scene.objects = {perception::MakeTop(
      "table", {.area_W = {Vector2(-0.2, -1.2), Vector2(1.8, 1.2)}, .top_m = kTableTop_m})};
  RandomDraws draws(options.seed, 39);
  for (int i = 0; i < std::min(options.thing_count, kRows * kColumns); ++i) {
    const int row_index = i / kColumns;
    const double row = row_index - 0.5 * (kRows - 1), column = i % kColumns - 2;
    const Vector3 offset(row * kRowStep_m + draws.Uniform(-kJitter_m, kJitter_m),
                         column * kColumnStep_m + draws.Uniform(-kJitter_m, kJitter_m), 0);
    const Quaternion yaw(
        Eigen::AngleAxisd(draws.Uniform(0, 2 * std::numbers::pi), Vector3::UnitZ()));
    SimulatedObject thing{.name = "thing_" + std::to_string(i + 1),
                          .parts = {RandomThing(draws)},
                          .X_WO = MakePose(kMiddle + offset, yaw)};
    script.scene.objects.push_back(std::move(thing));
  }
  for (int i = 0; i < options.sensor_count; ++i) script.sensors.push_back(Sensor(i));
  return script;
}

perception::SequenceScript PushedThing(double begin_s, const TableOptions& table) {
  constexpr double kWay_m = 0.08, kStroke_s = 2;
  perception::SequenceScript script = TableScript(table);
  const std::size_t thing = kFirstThing + 2;
  const Pose home = script.scene.objects[thing].X_WO;
  bool is_home = true;
  for (double time_s = begin_s; time_s + kStroke_s <= table.duration_s; time_s += kStroke_s) {
    const Pose target = is_home ? MakeTranslation(-kWay_m, 0, 0) * home : home;
    script.events.push_back({.object = thing,
                             .begin_s = time_s,
                             .end_s = time_s + kStroke_s,
                             .what = perception::MoveEvent{.X_WO = target}});
    is_home = !is_home;
  }
  return script;
}

void ScaleDown(int by, perception::SequenceScript& script) {
  for (perception::SequenceSensor& sensor : script.sensors) {
    sensor.camera.width /= by;
    sensor.camera.height /= by;
    sensor.camera.focal_px /= by;
    sensor.camera.center_x_px /= by;
    sensor.camera.center_y_px /= by;
    sensor.noise.image_width_px = sensor.camera.width;
  }
}

}  // namespace cwm::benchmarks
