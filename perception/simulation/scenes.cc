#include "perception/simulation/scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "perception/simulation/angles.h"
#include "perception/simulation/furniture.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

constexpr double kCounterHeight_m = 0.9;  // usual for kitchens
constexpr double kViewDistance_m = 0.9;   // from the camera to the middle of the objects
constexpr double kViewCenter_x_m = 0.64;  // = 0.9 cos 45 degrees: the camera is above the origin

struct Place {
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
};

// The object's frame is at the middle of its foot on the support, z up.
Pose StandAt(const Place& place) {
  return MakePose({place.x_m, place.y_m, kCounterHeight_m},
                  Quaternion(Eigen::AngleAxisd(place.yaw_rad, Vector3::UnitZ())));
}

// A solid whose frame is at its centre, standing on z = 0.
SimulatedObject Standing(std::string name, Shape shape, double height_m, const Place& place) {
  Placed<> part{.X_FS = MakeTranslation(0, 0, 0.5 * height_m), .shape = std::move(shape)};
  return {.name = std::move(name), .parts = {std::move(part)}, .X_WO = StandAt(place)};
}

SimulatedObject StandingBox(std::string name, const Vector3& size_m, const Place& place) {
  return Standing(std::move(name), Box{.size_m = size_m}, size_m.z(), place);
}

SimulatedObject StandingCan(std::string name, const Cylinder& can, const Place& place) {
  return Standing(std::move(name), can, can.length_m, place);
}

SimulatedObject Ball(std::string name, double radius_m, const Place& place) {
  return Standing(std::move(name), Sphere{.radius_m = radius_m}, 2 * radius_m, place);
}

SimulatedObject Cup(std::string name, const Cone& cup, const Place& place) {
  return Standing(std::move(name), cup, cup.length_m, place);
}

constexpr int kHandleSegments = 8;
constexpr double kHandleRadius_m = 0.026;  // of the arc
constexpr double kHandleTube_m = 0.006;

// The body and a handle of capsules along half a circle, towards x.
SimulatedObject Mug(std::string name, const Cylinder& body, const Place& place) {
  SimulatedObject mug = StandingCan(std::move(name), body, place);
  mug.part_roles = {PieceRole::kBody};
  const Vector3 center(body.radius_m, 0, 0.5 * body.length_m);
  const auto on_arc = [&](int i) {
    const double angle_rad = std::numbers::pi * (static_cast<double>(i) / kHandleSegments - 0.5);
    return Vector3(center + kHandleRadius_m * Vector3(std::cos(angle_rad), 0, std::sin(angle_rad)));
  };
  for (int i = 0; i < kHandleSegments; ++i) {
    const Vector3 chord = on_arc(i + 1) - on_arc(i);
    const Quaternion along(BasisFromZ(chord.normalized()));
    mug.parts.push_back({.X_FS = MakePose(0.5 * (on_arc(i) + on_arc(i + 1)), along),
                         .shape = Capsule{.radius_m = kHandleTube_m, .length_m = chord.norm()}});
    mug.part_roles.push_back(PieceRole::kHandle);
  }
  return mug;
}

SimulatedObject Slab(std::string name, const Eigen::AlignedBox2d& area_m, double thickness_m) {
  return MakeTop(std::move(name),
                 {.area_W = area_m, .top_m = kCounterHeight_m, .thickness_m = thickness_m});
}

// A disc of the table that is occupied.
struct Footprint {
  Vector2 center;
  double radius_m = 0;
};

constexpr double kGap_m =
    0.03;  // between footprints: more than 3 sigma of any sensor here but lasers

std::optional<Vector2> FindPlace(double radius_m, const Eigen::AlignedBox2d& area_m,
                                 const std::vector<Footprint>& taken, RandomDraws& draws) {
  constexpr int kAttempts = 300;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const double y_m = draws.Uniform(area_m.min().y(), area_m.max().y());
    const double x_m = draws.Uniform(area_m.min().x(), area_m.max().x());
    const Vector2 center(x_m, y_m);
    const bool is_free = std::all_of(taken.begin(), taken.end(), [&](const Footprint& other) {
      return (other.center - center).norm() > other.radius_m + radius_m + kGap_m;
    });
    if (is_free) return center;
  }
  return std::nullopt;
}

struct Candidate {
  SimulatedObject object;
  double footprint_radius_m = 0;
};

// Sizes of household goods.
Candidate RandomObject(int index, RandomDraws& draws) {
  const Place place{.yaw_rad = draws.Uniform(0, 2 * std::numbers::pi)};
  const std::string number = std::to_string(index);
  switch (static_cast<int>(draws.Uniform(0, 4))) {
    case 0: {
      const double z_m = draws.Uniform(0.05, 0.18), y_m = draws.Uniform(0.04, 0.10);
      const Vector3 size_m(draws.Uniform(0.05, 0.16), y_m, z_m);
      return {StandingBox("box_" + number, size_m, place), 0.5 * size_m.head<2>().norm()};
    }
    case 1: {
      const Cylinder can{.radius_m = draws.Uniform(0.025, 0.05),
                         .length_m = draws.Uniform(0.06, 0.18)};
      return {StandingCan("can_" + number, can, place), can.radius_m};
    }
    case 2: {
      const double radius_m = draws.Uniform(0.03, 0.06);
      return {Ball("ball_" + number, radius_m, place), radius_m};
    }
    default: {
      const double bottom_m = draws.Uniform(0.025, 0.035);
      const Cone cup{.radius_bottom_m = bottom_m,
                     .radius_top_m = bottom_m + draws.Uniform(0.012, 0.025),
                     .length_m = draws.Uniform(0.07, 0.13)};
      return {Cup("cup_" + number, cup, place), cup.radius_top_m};
    }
  }
}

}  // namespace

SimulatedScene KitchenCounter() {
  // Front edge at x = 0.3, wall behind x = 1.0; the cabinet's front stands back by 3 cm.
  const Eigen::AlignedBox2d top(Vector2(0.3, -0.8), Vector2(1.0, 0.8));
  SimulatedScene scene;
  scene.objects = {
      Slab("counter", top, 0.04),
      MakeBlock("cabinet",
                Aabb(Vector3(0.33, -0.8, 0), Vector3(1.0, 0.8, kCounterHeight_m - 0.04))),
      MakeBlock("wall", Aabb(Vector3(1.0, -0.8, 0), Vector3(1.05, 0.8, 2.5))),
      StandingBox("cereal", {0.07, 0.19, 0.27}, {0.86, -0.24, Radians(-20)}),
      StandingBox("tea", {0.08, 0.13, 0.07}, {0.56, -0.30, Radians(25)}),
      StandingBox("sugar", {0.06, 0.10, 0.15}, {0.84, 0.08, Radians(35)}),
      StandingCan("soup", {.radius_m = 0.0375, .length_m = 0.11}, {0.64, -0.08, 0}),
      StandingCan("soda", {.radius_m = 0.033, .length_m = 0.122}, {0.82, 0.34, 0}),
      Ball("ball", 0.05, {0.48, 0.06, 0}),
      Cup("cup", {.radius_bottom_m = 0.028, .radius_top_m = 0.045, .length_m = 0.10},
          {0.64, 0.22, 0}),
      Mug("mug", {.radius_m = 0.041, .length_m = 0.095}, {0.46, 0.30, Radians(-120)}),
  };
  return scene;
}

PinholeCamera KitchenCamera() {
  PinholeCamera camera;
  const double pitch_rad = Radians(45);
  const Vector3 forward(std::cos(pitch_rad), 0, -std::sin(pitch_rad));
  const Vector3 right = -Vector3::UnitY();
  Pose& X_WC = camera.X_WC;
  X_WC.linear() << right, forward.cross(right), forward;
  X_WC.translation() = Vector3(kViewCenter_x_m, 0, kCounterHeight_m) - kViewDistance_m * forward;
  return camera;
}

SimulatedScene RandomTable(std::uint64_t seed, int object_count) {
  RandomDraws draws(seed, 0);
  const Eigen::AlignedBox2d top(Vector2(0.25, -0.6), Vector2(1.1, 0.6));
  const Eigen::AlignedBox2d seen(Vector2(0.42, -0.34), Vector2(0.9, 0.34));  // by KitchenCamera
  SimulatedScene scene;
  scene.objects.push_back(Slab("table", top, 0.03));
  std::vector<Footprint> taken;
  for (int i = 1; i <= object_count; ++i) {
    Candidate candidate = RandomObject(i, draws);
    const auto center = FindPlace(candidate.footprint_radius_m, seen, taken, draws);
    if (!center) continue;
    candidate.object.X_WO.translation().head<2>() = *center;
    taken.push_back({.center = *center, .radius_m = candidate.footprint_radius_m});
    scene.objects.push_back(std::move(candidate.object));
  }
  return scene;
}

}  // namespace cwm::perception
