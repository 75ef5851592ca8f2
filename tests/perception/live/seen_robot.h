// A small robot in a frame, with the truth of each pixel.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "collision/geometry/signed_distance.h"
#include "perception/live/robot_view.h"
#include "tests/perception/live/robot_scene.h"

namespace cwm::perception {

// Small margins, so that little is near a margin's edge.
inline SensorNoise FineNoise() { return {.model = SensorModel::kGiven, .given_sigma_m = 0.001}; }

// A frame of the scene as the robot stands in it.
struct SeenRobot {
  RobotScene scene = {};
  SmallRobot robot = Arm();
  RobotMargins margins = {};
  StateSource source = StateSource::kInterpolated;
  double late_s = 0;
  std::vector<CarriedAtStamp> carried = {};
  bool with_expected = true;

  // Filled by Take.
  RangeImage truth = {};
  DepthImage image = {};
  std::vector<float> expected_m = {};

  void Take() {
    truth = scene.Sightings(&robot);
    image = DepthsOf(truth);
    expected_m = ExpectedOf(scene.Sightings(nullptr));
  }
  // What is told of the image if the links are believed to be at `poses`.
  RobotSighting Mask(const std::vector<LinkAtStamp>& poses) const {
    const DepthCamera camera = scene.camera();
    RobotFrame frame{
        .camera = &camera, .X_WC = scene.pinhole.X_WC, .image = &image, .noise = FineNoise()};
    if (with_expected) frame.expected_m = expected_m;
    RobotView view(robot.Surface());
    return view.Mask(frame, {.source = source, .late_s = late_s, .links = poses}, carried, margins);
  }
  RobotSighting Mask() const { return Mask(robot.poses); }

  bool ShowsRobot(std::size_t pixel) const {
    return truth.pixels[pixel].object >= scene.thing_count();
  }
  Vector3 Point(std::size_t pixel) const {
    const auto width = static_cast<std::size_t>(image.width);
    const std::size_t u = pixel % width, v = pixel / width;
    return scene.pinhole.X_WC *
           Vector3(image.depth_m[pixel] *
                   RayDirection(scene.pinhole, static_cast<double>(u), static_cast<double>(v)));
  }
  // The signed distance of a pixel's point from the nearest link.
  double RobotDistance_m(std::size_t pixel) const {
    double distance_m = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < robot.links.size(); ++i) {
      for (const Shape& shape : robot.links[i]) {
        const Vector3 p_L = robot.poses[i].X_WL.inverse() * Point(pixel);
        distance_m = std::min(distance_m, SignedDistance_m(shape, p_L));
      }
    }
    return distance_m;
  }
  // True if a pixel that shows the robot is at most `reach_px` away.
  bool IsNearRobot(std::size_t pixel, int reach_px) const {
    const int u = static_cast<int>(pixel) % image.width, v = static_cast<int>(pixel) / image.width;
    for (int y = std::max(0, v - reach_px); y <= std::min(image.height - 1, v + reach_px); ++y) {
      for (int x = std::max(0, u - reach_px); x <= std::min(image.width - 1, u + reach_px); ++x) {
        if (ShowsRobot(static_cast<std::size_t>(y) * image.width + x)) return true;
      }
    }
    return false;
  }
};

inline std::uint8_t At(const RobotSighting& sighting, std::size_t pixel) {
  return sighting.mask.empty() ? std::uint8_t{0} : sighting.mask.pixels[pixel];
}

inline std::int64_t CountOf(const RobotSighting& sighting, std::uint8_t pixel_class) {
  return std::count(sighting.mask.pixels.begin(), sighting.mask.pixels.end(), pixel_class);
}

}  // namespace cwm::perception
