// A small robot before a table, with images of it that the scanner's ray casts make: they share
// nothing with the code under test.
#pragma once

#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "perception/live/robot_view.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/range_image.h"

namespace cwm::perception {

// The classes as the mask holds them; 0: none.
inline constexpr auto kRobotByte = static_cast<std::uint8_t>(PixelClass::kRobot);
inline constexpr auto kCarriedByte = static_cast<std::uint8_t>(PixelClass::kCarried);
inline constexpr auto kMixedByte = static_cast<std::uint8_t>(PixelClass::kMixed);
inline constexpr auto kHiddenByte = static_cast<std::uint8_t>(PixelClass::kHidden);

// One shape a link, at the link's origin; a link without a shape has no geometry.
struct SmallRobot {
  std::vector<std::vector<Shape>> links = {};
  std::vector<LinkAtStamp> poses = {};

  std::shared_ptr<const RobotSurface> Surface() const {
    std::vector<LinkGeometry> geometries;
    for (std::size_t i = 0; i < links.size(); ++i) {
      for (const Shape& shape : links[i]) {
        geometries.push_back({.link = static_cast<int>(i), .shape = &shape});
      }
    }
    return std::make_shared<RobotSurface>(geometries, static_cast<int>(links.size()));
  }
};

// An upright arm of a cylinder and a box, 0.3 m above a table whose top is z = 0.
inline SmallRobot Arm() {
  SmallRobot robot;
  robot.links = {{Cylinder{.radius_m = 0.06, .length_m = 0.4}}, {}, {Box{{0.3, 0.1, 0.08}}}};
  robot.poses = {{MakeTranslation(0, 0, 0.5)}, {}, {MakeTranslation(0.12, 0, 0.72)}};
  return robot;
}

// The bodies that a frame shows: things first, then the robot's links.
struct RobotScene {
  PinholeCamera pinhole = {
      .width = 320, .height = 240, .focal_px = 262, .center_x_px = 159.5, .center_y_px = 119.5};
  SimulatedScene things = {};

  RobotScene() {
    pinhole.X_WC = LookAt(Vector3(0.9, -0.9, 1.2), Vector3(0, 0, 0.4));
    things.objects.push_back({.name = "table",
                              .parts = {{Pose::Identity(), Box{{3, 3, 0.1}}}},
                              .X_WO = MakeTranslation(0, 0, -0.05)});
  }

  DepthCamera camera() const {
    return {
        .pinhole = {pinhole.focal_px, pinhole.focal_px, pinhole.center_x_px, pinhole.center_y_px},
        .width = pinhole.width,
        .height = pinhole.height,
        .least_range_m = 0.02F};
  }
  int thing_count() const { return static_cast<int>(things.objects.size()); }

  // An ideal image of the things, and of the robot if it is not null.
  RangeImage Sightings(const SmallRobot* robot) const {
    SimulatedScene scene = things;
    for (std::size_t i = 0; robot != nullptr && i < robot->links.size(); ++i) {
      SimulatedObject& link = scene.objects.emplace_back();
      link.X_WO = robot->poses[i].X_WL;
      for (const Shape& shape : robot->links[i]) link.parts.push_back({Pose::Identity(), shape});
    }
    return Render(scene, pinhole);
  }
};

inline DepthImage DepthsOf(const RangeImage& image) {
  DepthImage depths{.width = image.width, .height = image.height, .depth_m = {}};
  for (const Sighting& pixel : image.pixels) {
    depths.depth_m.push_back(static_cast<float>(pixel.depth_m));
  }
  return depths;
}

inline std::vector<float> ExpectedOf(const RangeImage& image) {
  std::vector<float> depths_m;
  for (const Sighting& pixel : image.pixels) {
    depths_m.push_back(pixel.seen() ? static_cast<float>(pixel.depth_m)
                                    : std::numeric_limits<float>::infinity());
  }
  return depths_m;
}

inline Pose RandomPose(std::mt19937_64& random, double spread_m) {
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(random); };
  const Quaternion turn = Quaternion(draw(), draw(), draw(), draw()).normalized();
  return MakePose(spread_m * Vector3(draw(), draw(), draw()), turn);
}

}  // namespace cwm::perception
