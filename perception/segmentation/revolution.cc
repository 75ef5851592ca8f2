#include "perception/segmentation/revolution.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "perception/cloud/quantile.h"

namespace cwm::perception {
namespace {

constexpr double kLeastSteepness = 0.35;  // horizontal part of a normal that has a direction
constexpr double kMostMiss_sin = 0.3;     // 17 degrees: three standard deviations of a normal
constexpr double kLeastMiss_m = 0.012;    // error of an axis known from half of a cup's outside
// (a - sin a cos a) / (a + sin a cos a) for an arc of +-a: 30 degrees. Faces of boxes that fan out
// by chance fail the agreement.
constexpr double kLeastFan = 0.1;
constexpr std::size_t kLeastMembers = 20;  // as the header says; chosen: two independent normals
constexpr int kRounds = 4;  // chosen: the first one by all normals, the rest by those that agree

struct Ray {
  Vector2 from, direction;  // direction is unit
};

std::vector<Ray> SteepRays(const OrientedPoints& points, std::span<const std::uint32_t> members) {
  std::vector<Ray> rays;
  for (std::uint32_t i : members) {
    const Vector2 n = points.normals[i].head<2>().cast<double>();
    const double steepness = n.norm();
    if (steepness < kLeastSteepness) continue;
    rays.push_back({points.points[i].head<2>().cast<double>(), n / steepness});
  }
  return rays;
}

// Whether the line of the normal passes the axis as near as noise allows.
bool Agrees(const Ray& ray, const Vector2& axis) {
  const Vector2 to = ray.from - axis;
  const double miss = std::abs(to.x() * ray.direction.y() - to.y() * ray.direction.x());
  return miss <= std::max(kLeastMiss_m, kMostMiss_sin * to.norm());
}

}  // namespace

Revolution JudgeRevolution(const OrientedPoints& points, std::span<const std::uint32_t> members,
                           const Vector2& axis) {
  Revolution out{.axis = axis};
  const std::vector<Ray> rays = SteepRays(points, members);
  if (members.empty() || rays.empty()) return out;
  std::vector<double> distances;
  double agreeing = 0, outward = 0;
  for (const Ray& ray : rays) {
    distances.push_back((ray.from - axis).norm());
    if (!Agrees(ray, axis)) continue;
    agreeing += 1;
    outward += (ray.from - axis).dot(ray.direction) > 0;
  }
  out.radius_m = Quantile(std::move(distances), 0.9);
  out.steep = static_cast<double>(rays.size()) / static_cast<double>(members.size());
  out.agreement = agreeing / static_cast<double>(rays.size());
  out.outward = agreeing > 0 ? outward / agreeing : 0;
  return out;
}

std::optional<Revolution> FitRevolution(const OrientedPoints& points,
                                        std::span<const std::uint32_t> members) {
  const std::vector<Ray> rays = SteepRays(points, members);
  if (rays.size() < kLeastMembers) return std::nullopt;
  Vector2 axis = Vector2::Zero();
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
    Vector2 right = Vector2::Zero();
    for (const Ray& ray : rays) {
      if (round > 0 && !Agrees(ray, axis)) continue;
      const Eigen::Matrix2d across =
          Eigen::Matrix2d::Identity() - ray.direction * ray.direction.transpose();
      sum += across;
      right += across * ray.from;
    }
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
    solver.computeDirect(sum);
    if (solver.eigenvalues()(0) < kLeastFan * solver.eigenvalues()(1)) return std::nullopt;
    axis = sum.inverse() * right;
  }
  return JudgeRevolution(points, members, axis);
}

}  // namespace cwm::perception
