#include "clients/cli/bench/scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include "clients/cli/bench/bench_poses.h"

namespace cwm::cli {
namespace {

using Vector3 = std::array<double, 3>;

constexpr int kWidth = 640, kHeight = 480;
constexpr double kFocalLength_px = 525;  // a Kinect's
constexpr double kNoHit = std::numeric_limits<double>::infinity();

// Beside the table and behind it is the floor.
constexpr Region kTable{.min = {-0.6, -0.4, -0.02}, .max = {0.6, 0.4, 0}};
constexpr double kFloor_m = -0.7;
constexpr std::array<Region, 3> kBoxes = {{{.min = {-0.35, 0.05, 0}, .max = {-0.15, 0.15, 0.24}},
                                           {.min = {0.0, 0.1, 0}, .max = {0.12, 0.22, 0.1}},
                                           {.min = {0.1, -0.25, 0}, .max = {0.28, -0.19, 0.06}}}};
struct SceneBall {
  Vector3 centre_m;
  double radius_m;
};
constexpr std::array<SceneBall, 3> kBalls = {{{.centre_m = {-0.1, -0.15, 0.05}, .radius_m = 0.05},
                                              {.centre_m = {0.35, 0.05, 0.08}, .radius_m = 0.08},
                                              {.centre_m = {-0.4, -0.2, 0.04}, .radius_m = 0.04}}};

// The camera's position in the world; it looks at the middle of the table, along z with x to the
// right.
constexpr Vector3 kEye_m = {0, -0.7, 0.8};

double Dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The surface's distance from the eye in multiples of `direction`; kNoHit if the ray misses it.
double HitBox(const Region& box, const Vector3& direction) {
  double enter = 0, leave = kNoHit;
  for (std::size_t k = 0; k < 3; ++k) {
    const double one = (box.min[k] - kEye_m[k]) / direction[k];
    const double other = (box.max[k] - kEye_m[k]) / direction[k];
    enter = std::max(enter, std::min(one, other));
    leave = std::min(leave, std::max(one, other));
  }
  return enter < leave ? enter : kNoHit;
}

double HitBall(const SceneBall& ball, const Vector3& direction) {
  const Vector3 to_centre = {ball.centre_m[0] - kEye_m[0], ball.centre_m[1] - kEye_m[1],
                             ball.centre_m[2] - kEye_m[2]};
  const double a = Dot(direction, direction), b = Dot(direction, to_centre);
  const double discriminant =
      b * b - a * (Dot(to_centre, to_centre) - ball.radius_m * ball.radius_m);
  return discriminant < 0 ? kNoHit : (b - std::sqrt(discriminant)) / a;
}

double Depth_m(const Vector3& direction) {
  double depth = HitBox(kTable, direction);
  if (direction[2] < 0) depth = std::min(depth, (kFloor_m - kEye_m[2]) / direction[2]);
  for (const Region& box : kBoxes) depth = std::min(depth, HitBox(box, direction));
  for (const SceneBall& ball : kBalls) depth = std::min(depth, HitBall(ball, direction));
  return depth;
}

// cited: Nguyen, Izadi and Lovell, Modeling Kinect sensor noise, 2012: the axial noise.
double Noise_m(double depth_m, Random& random) {
  const double sigma_m = 0.0012 + 0.0019 * (depth_m - 0.4) * (depth_m - 0.4);
  // cited: Box and Muller, 1958; 1 - u is never 0.
  const double radius = std::sqrt(-2 * std::log(1 - random.Uniform(0, 1)));
  return sigma_m * radius * std::cos(random.Uniform(0, 2 * std::numbers::pi));
}

}  // namespace

formats::CloudFile BenchScan() {
  formats::CloudFile cloud;
  for (const char* name : {"x", "y", "z"}) cloud.fields.push_back({.name = name});
  cloud.point_step = formats::AssignOffsets(cloud.fields);
  cloud.width = kWidth;
  cloud.height = kHeight;
  cloud.bytes.reserve(cloud.point_step * static_cast<std::size_t>(cloud.size()));
  const double length = std::hypot(kEye_m[1], kEye_m[2]);
  const Vector3 forward = {0, -kEye_m[1] / length, -kEye_m[2] / length};
  const Vector3 down = {0, forward[2], -forward[1]};  // forward x right
  Random random(42);
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const double x = (column - 0.5 * (kWidth - 1)) / kFocalLength_px;
      const double y = (row - 0.5 * (kHeight - 1)) / kFocalLength_px;
      const double depth_m = Depth_m({x, y * down[1] + forward[1], y * down[2] + forward[2]});
      const double seen_m = depth_m == kNoHit ? std::numeric_limits<double>::quiet_NaN()
                                              : depth_m + Noise_m(depth_m, random);
      const std::array<float, 3> point = {static_cast<float>(x * seen_m),
                                          static_cast<float>(y * seen_m),
                                          static_cast<float>(seen_m)};
      cloud.bytes.append(reinterpret_cast<const char*>(point.data()), sizeof(point));
    }
  }
  return cloud;
}

}  // namespace cwm::cli
