#include "perception/segmentation/revolution.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// chosen: the least number of steep normals that determine an axis, nearly two independent ones.
constexpr std::size_t kMinSteepNormals = 20;

// measured: the error of an axis that is determined by half of a cup's outside.
constexpr double kAxisMiss_m = 0.012;
// derived: (a - sin a cos a) / (a + sin a cos a) for an arc of +-a, with a = 30 degrees. Faces of
// boxes that fan out by chance fail the test of agreement.
constexpr double kMinFan = 0.1;

struct Ray {
  Vector2 from, direction;  // direction is unit
};

std::vector<Ray> SteepRays(const OrientedPoints& points, std::span<const std::uint32_t> members) {
  std::vector<Ray> rays;
  for (std::uint32_t i : members) {
    const Vector2 n = points.normals[i].head<2>().cast<double>();
    const double steepness = n.norm();
    if (steepness < kSteep_sin) continue;
    rays.push_back({points.points[i].head<2>().cast<double>(), n / steepness});
  }
  return rays;
}

// True if the line of the normal passes the axis within the noise.
bool Agrees(const Ray& ray, const Vector2& axis) {
  const Vector2 to = ray.from - axis;
  const double miss = std::abs(to.x() * ray.direction.y() - to.y() * ray.direction.x());
  return miss <= std::max(kAxisMiss_m, kNormalMiss_sin * to.norm());
}

}  // namespace

Revolution EvaluateRevolution(const OrientedPoints& points, std::span<const std::uint32_t> members,
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
  out.radius_m = Quantile(std::move(distances), kNearlyAll);
  out.steep = static_cast<double>(rays.size()) / static_cast<double>(members.size());
  out.agreement = agreeing / static_cast<double>(rays.size());
  out.outward = agreeing > 0 ? outward / agreeing : 0;
  return out;
}

std::optional<Revolution> FitRevolution(const OrientedPoints& points,
                                        std::span<const std::uint32_t> members) {
  const std::vector<Ray> rays = SteepRays(points, members);
  if (rays.size() < kMinSteepNormals) return std::nullopt;
  Vector2 axis = Vector2::Zero();
  // The first round uses all normals, later rounds those that agree.
  for (int round = 0; round <= kRefinements; ++round) {
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
    if (solver.eigenvalues()(0) < kMinFan * solver.eigenvalues()(1)) return std::nullopt;
    axis = sum.inverse() * right;
  }
  return EvaluateRevolution(points, members, axis);
}

}  // namespace cwm::perception
