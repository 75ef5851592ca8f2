#include "perception/simulation/household_goods.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "collision/geometry/aabb.h"
#include "perception/simulation/angles.h"

namespace cwm::perception {
namespace {

Quaternion AboutY(double angle_rad) {
  return Quaternion(Eigen::AngleAxisd(angle_rad, Vector3::UnitY()));
}

// The shape, rotated, with its lowest point at z = 0 and its centre above the frame's origin.
SimulatedObject Resting(GoodsKind kind, Shape shape, const Quaternion& turn) {
  Pose X_OS = MakePose(Vector3::Zero(), turn);
  X_OS.translation().z() = -TightBounds(shape, X_OS).min().z();
  return {.name = std::string(NameOf(kind)), .parts = {{.X_FS = X_OS, .shape = std::move(shape)}}};
}

// A tilt, in radians, at which an object with this foot and height falls over, plus 4 to 30
// degrees: from a book that nearly stands to a board that has slid down.
double DrawLean_rad(double half_foot_m, double half_height_m, RandomDraws& draws) {
  return std::atan2(half_foot_m, half_height_m) + Radians(draws.Uniform(4, 30));
}

// The ratio of height to foot above which an object is knocked over easily.
constexpr double kMaxSlender = 4;

SimulatedObject DrawCylinder(RestPose rest, RandomDraws& draws) {
  const Cylinder cylinder{.radius_m = draws.Uniform(0.015, 0.060),
                          .length_m = draws.Uniform(0.04, 0.25)};
  const double slenderness = cylinder.length_m / (2 * cylinder.radius_m);
  if (slenderness < 0.8) rest = RestPose::kStanding;  // a disc would roll away
  if (rest == RestPose::kStanding && slenderness > kMaxSlender) rest = RestPose::kLying;
  if (rest == RestPose::kLeaning && slenderness < 1.5) rest = RestPose::kLying;
  double tilt_rad = 0;
  if (rest == RestPose::kLying) tilt_rad = Radians(90);
  if (rest == RestPose::kLeaning) {
    tilt_rad = DrawLean_rad(cylinder.radius_m, 0.5 * cylinder.length_m, draws);
  }
  return Resting(GoodsKind::kCylinder, cylinder, AboutY(tilt_rad));
}

SimulatedObject DrawSphere(RandomDraws& draws) {
  return Resting(GoodsKind::kSphere, Sphere{.radius_m = draws.Uniform(0.020, 0.060)},
                 Quaternion::Identity());
}

SimulatedObject DrawCup(RestPose rest, RandomDraws& draws) {
  const double half_angle_rad = Radians(draws.Uniform(4, 15));
  const double length_m = draws.Uniform(0.05, 0.14);
  const double narrow_m = draws.Uniform(0.020, 0.035);
  const double wide_m = narrow_m + length_m * std::tan(half_angle_rad);
  const bool turned_over = draws.Uniform() < 0.4;
  const Cone cup{.radius_bottom_m = turned_over ? wide_m : narrow_m,
                 .radius_top_m = turned_over ? narrow_m : wide_m,
                 .length_m = length_m};
  if (rest != RestPose::kLying) return Resting(GoodsKind::kCup, cup, Quaternion::Identity());
  // The axis rises or falls by the half angle, so that the generatrix below it is level.
  const double slope_rad = turned_over ? -half_angle_rad : half_angle_rad;
  return Resting(GoodsKind::kCup, cup, AboutY(Radians(90) - slope_rad));
}

// Small edges are more frequent: the square of a uniform draw.
double DrawEdge_m(RandomDraws& draws) {
  const double share = draws.Uniform();
  return 0.04 + 0.26 * share * share;
}

SimulatedObject DrawBox(RestPose rest, RandomDraws& draws) {
  Vector3 size_m{DrawEdge_m(draws), DrawEdge_m(draws), DrawEdge_m(draws)};
  if (rest == RestPose::kLeaning) {  // on its shortest side, with the thin side towards the holder
    std::sort(size_m.begin(), size_m.end());
    if (size_m.z() > 1.8 * size_m.x()) {
      const double lean_rad = DrawLean_rad(0.5 * size_m.x(), 0.5 * size_m.z(), draws);
      return Resting(GoodsKind::kBox, Box{.size_m = size_m}, AboutY(lean_rad));
    }
  }
  const double min_foot_m = std::min(size_m.x(), size_m.y());
  if (size_m.z() > kMaxSlender * min_foot_m) {
    std::sort(size_m.begin(), size_m.end(), std::greater<>());  // flat instead
  }
  return Resting(GoodsKind::kBox, Box{.size_m = size_m}, Quaternion::Identity());
}

}  // namespace

std::string_view NameOf(GoodsKind kind) {
  switch (kind) {
    case GoodsKind::kCylinder:
      return "cylinder";
    case GoodsKind::kSphere:
      return "sphere";
    case GoodsKind::kCup:
      return "cup";
    case GoodsKind::kBox:
      return "box";
  }
  return "box";
}

SimulatedObject DrawGoods(GoodsKind kind, RestPose rest, RandomDraws& draws) {
  switch (kind) {
    case GoodsKind::kCylinder:
      return DrawCylinder(rest, draws);
    case GoodsKind::kSphere:
      return DrawSphere(draws);
    case GoodsKind::kCup:
      return DrawCup(rest, draws);
    case GoodsKind::kBox:
      return DrawBox(rest, draws);
  }
  return DrawBox(rest, draws);
}

}  // namespace cwm::perception
