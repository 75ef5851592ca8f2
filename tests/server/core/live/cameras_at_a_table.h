// Three fixed depth cameras at a table with twelve things, as a script of the simulator.
#pragma once

#include <array>
#include <numbers>
#include <string>

#include "perception/simulation/furniture.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/sequence_renderer.h"

namespace cwm::server {

inline constexpr int kThings = 12;
inline constexpr double kTableTop_m = 0.75;

// Cartons and cans on a table, before cameras of a quarter of a Kinect's pixels: one before it, and
// one at each side, which look at each other.
inline perception::SequenceScript CamerasAtATable() {
  const Vector3 middle(0.7, 0, kTableTop_m);
  perception::SequenceScript script;
  script.duration_s = 12;
  script.start_stamp_s = 1'700'000'000;
  script.scene.objects = {perception::MakeTop(
      "table", {.area_W = {Vector2(-0.2, -1.2), Vector2(1.8, 1.2)}, .top_m = kTableTop_m})};
  for (int i = 0; i < kThings; ++i) {
    const int row = i / 4, column = i % 4;
    const double height_m = 0.08 + 0.01 * (i % 5);
    const Shape carton = Box{.size_m = {0.09, 0.06, height_m}};
    const Shape can = Cylinder{.radius_m = 0.04, .length_m = height_m};
    const Quaternion yaw(Eigen::AngleAxisd(0.7 * i, Vector3::UnitZ()));
    script.scene.objects.push_back(
        {.name = "thing_" + std::to_string(i),
         .parts = {{.X_FS = MakeTranslation(0, 0, 0.5 * height_m),
                    .shape = i % 2 == 0 ? carton : can}},
         .X_WO = MakePose(Vector3(0.5 + 0.2 * row, -0.3 + 0.2 * column, kTableTop_m), yaw)});
  }
  for (const Vector3& eye :
       {Vector3(0.15, 0, 1.55), Vector3(0.5, -0.7, 1.5), Vector3(0.5, 0.7, 1.5)}) {
    perception::SequenceSensor sensor;
    sensor.name = "camera_" + std::to_string(script.sensors.size() + 1);
    sensor.camera.width = 320;
    sensor.camera.height = 240;
    sensor.camera.focal_px /= 2;
    sensor.camera.center_x_px = 159.5;
    sensor.camera.center_y_px = 119.5;
    sensor.mount = perception::LookAt(eye, middle);
    sensor.device_seed = 100 + script.sensors.size();
    script.sensors.push_back(sensor);
  }
  return script;
}

// The pose with an error of calibration, along and about the given directions.
inline Pose Wrong(Pose X_WC, double shift_m, double turn_deg,
                  const Vector3& along_W = Vector3(2, -1, 1),
                  const Vector3& about_W = Vector3(1, 2, -2)) {
  X_WC.translation() += shift_m * along_W.normalized();
  const Eigen::AngleAxisd turn(turn_deg * std::numbers::pi / 180, about_W.normalized());
  X_WC.linear() = turn.toRotationMatrix() * X_WC.linear();
  return X_WC;
}

// How well the poses of sensors are known: millimetres and degrees, the same for all of them.
struct CalibrationError {
  double shift_m = 0;
  double turn_deg = 0;
};
inline constexpr std::array<CalibrationError, 4> kCalibrationErrors = {
    {{0, 0}, {0.003, 0.2}, {0.006, 0.4}, {0.012, 0.6}}};

// The pose of a camera of the script with an error of that size, in another direction for each.
inline Pose GivenPose(const perception::SequenceScript& script, std::size_t sensor,
                      const CalibrationError& error) {
  constexpr double kAngle = 2 * std::numbers::pi / 3;
  const double angle = kAngle * static_cast<double>(sensor);
  return Wrong(CameraAt(script, script.sensors[sensor], 0).X_WC, error.shift_m, error.turn_deg,
               {std::cos(angle), std::sin(angle), 0.5}, {std::sin(angle), 1, std::cos(angle)});
}

}  // namespace cwm::server
