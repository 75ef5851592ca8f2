#include "collision/spheres/solid_spheres.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "collision/geometry/quick_bounds.h"
#include "collision/geometry/signed_distance.h"

namespace cwm::collision {
namespace {

// derived: radii are rounded some dozen times; this is added to those of spheres around a solid and
// taken from those of spheres within it.
constexpr double kRounding = 1e-12;

// The part of a solid of revolution between two planes across its axis z, with the radius that it
// has at most.
struct Slice {
  double middle_m, half_m, radius_m;
};

// Slices about as long as they are wide.
std::vector<Slice> SlicesOf(double length_m, double radius_bottom_m, double radius_top_m) {
  constexpr double kMaxSlices = 8;
  const double radius_m = std::max(radius_bottom_m, radius_top_m);
  const double count = std::clamp(std::ceil(length_m / radius_m), 1.0, kMaxSlices);
  std::vector<Slice> slices;
  for (double k = 0; k < count; ++k) {
    const auto radius_at = [&](double step) {
      return std::lerp(radius_bottom_m, radius_top_m, step / count);
    };
    slices.push_back({.middle_m = length_m * ((k + 0.5) / count - 0.5),
                      .half_m = 0.5 * length_m / count,
                      .radius_m = std::max(radius_at(k), radius_at(k + 1))});
  }
  return slices;
}

std::vector<Ball> AroundSlices(const std::vector<Slice>& slices) {
  std::vector<Ball> balls;
  for (const Slice& slice : slices) {
    balls.push_back({{0, 0, slice.middle_m}, std::hypot(slice.half_m, slice.radius_m)});
  }
  return balls;
}

// The first and the last ball contain the caps, since their centres are those of the caps.
std::vector<Ball> AroundSegment(const Capsule& capsule) {
  constexpr double kMaxSteps = 8;
  const double steps = std::clamp(std::ceil(capsule.length_m / capsule.radius_m), 1.0, kMaxSteps);
  std::vector<Ball> balls;
  for (double k = 0; k <= steps; ++k) {
    balls.push_back({{0, 0, capsule.length_m * (k / steps - 0.5)},
                     std::hypot(0.5 * capsule.length_m / steps, capsule.radius_m)});
  }
  return balls;
}

// Balls around the cells of a grid in the box.
std::vector<Ball> AroundCells(const Aabb& box) {
  constexpr double kMaxCells = 3;  // along an axis
  const Vector3 size = box.sizes();
  const double edge_m = std::max(size.minCoeff(), size.maxCoeff() / kMaxCells);
  std::array<int, 3> count = {1, 1, 1};
  Vector3 cell = size;
  for (int axis = 0; axis < 3; ++axis) {
    if (edge_m <= 0) continue;
    count[static_cast<std::size_t>(axis)] =
        static_cast<int>(std::clamp(std::round(size[axis] / edge_m), 1.0, kMaxCells));
    cell[axis] = size[axis] / count[static_cast<std::size_t>(axis)];
  }
  std::vector<Ball> balls;
  for (int i = 0; i < count[0]; ++i) {
    for (int j = 0; j < count[1]; ++j) {
      for (int k = 0; k < count[2]; ++k) {
        const Vector3 middle = Vector3(i, j, k) + Vector3::Constant(0.5);
        balls.push_back({box.min() + middle.cwiseProduct(cell), 0.5 * cell.norm()});
      }
    }
  }
  return balls;
}

std::vector<Ball> BallsAround(const Shape& shape) {
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    return AroundSlices(SlicesOf(cylinder->length_m, cylinder->radius_m, cylinder->radius_m));
  }
  if (const auto* cone = std::get_if<Cone>(&shape)) {
    return AroundSlices(SlicesOf(cone->length_m, cone->radius_bottom_m, cone->radius_top_m));
  }
  if (const auto* capsule = std::get_if<Capsule>(&shape)) {
    return AroundSegment(*capsule);
  }
  return AroundCells(TightBounds(shape, Pose::Identity()));
}

// The largest balls in the shape about the same centres.
std::vector<Ball> BallsWithin(const Shape& shape, const std::vector<Ball>& around) {
  std::vector<Ball> within;
  double largest_m = 0;
  for (const Ball& ball : around) {
    const double radius_m = -SignedDistance_m(shape, ball.centre);
    if (radius_m > 0) within.push_back({ball.centre, radius_m});
    largest_m = std::max(largest_m, radius_m);
  }
  std::erase_if(within, [&](const Ball& ball) { return ball.radius_m < 0.5 * largest_m; });
  return within;
}

}  // namespace

SolidSpheres SpheresOf(const Shape& shape, const Pose& X_OS) {
  SolidSpheres spheres;
  if (std::holds_alternative<HalfSpace>(shape)) return spheres;
  if (const auto* sphere = std::get_if<Sphere>(&shape)) {
    return {.around = {{X_OS.translation(), sphere->radius_m}}, .within = {}, .is_exact = true};
  }
  spheres.around = BallsAround(shape);
  if (!std::holds_alternative<Mesh>(shape)) {
    spheres.within = BallsWithin(shape, spheres.around);
  }
  const auto place = [&](std::vector<Ball>& balls, double sign) {
    for (Ball& ball : balls) {
      const double scale_m = ball.radius_m + ball.centre.norm() + X_OS.translation().norm();
      ball.radius_m = std::max(0.0, ball.radius_m + sign * kRounding * scale_m);
      ball.centre = X_OS * ball.centre;
    }
  };
  place(spheres.around, 1);
  place(spheres.within, -1);
  return spheres;
}

}  // namespace cwm::collision
