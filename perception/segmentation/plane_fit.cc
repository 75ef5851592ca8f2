#include "perception/segmentation/plane_fit.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "perception/cloud/split_mix.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// derived: with kMinInlierShare, 0.4^3 = 0.064 of the triples consist of inliers only; this many
// triples miss all of them with a probability below 1 %.
constexpr int kTriples = 72;

std::optional<Plane> PlaneOfTriple(const OrientedPoints& points, const std::uint32_t (&triple)[3]) {
  Vector3 p[3], n[3];
  for (int k = 0; k < 3; ++k) {
    p[k] = points.points[triple[k]].cast<double>();
    n[k] = points.normals[triple[k]].cast<double>();
  }
  Vector3 normal = (p[1] - p[0]).cross(p[2] - p[0]);
  const double area = normal.norm();
  // Flatter triples than this amplify the noise of the points beyond use.
  if (area < 0.05 * std::max((p[1] - p[0]).squaredNorm(), (p[2] - p[0]).squaredNorm()) ||
      area < 1e-9) {
    return std::nullopt;
  }
  normal /= area;
  if (normal.dot(n[0]) < 0) normal = -normal;
  static const double min_cos = std::cos(kSameNormal_rad);
  for (const Vector3& other : n) {
    if (normal.dot(other) < min_cos) return std::nullopt;
  }
  return Plane{normal, normal.dot(p[0])};
}

// MSAC: truncated squares, smaller is better.
double Cost(const Plane& plane, const OrientedPoints& points,
            std::span<const std::uint32_t> members) {
  const std::size_t stride = std::max<std::size_t>(1, members.size() / kMaxScanned);
  double cost = 0;
  for (std::size_t k = 0; k < members.size(); k += stride) {
    const std::uint32_t i = members[k];
    const double r = plane.Height_m(points.points[i]) / (kGate_sigma * points.sigma_m[i]);
    cost += std::min(1.0, r * r);
  }
  return cost;
}

}  // namespace

std::vector<std::uint32_t> Inliers(const Plane& plane, const OrientedPoints& points,
                                   std::span<const std::uint32_t> members) {
  std::vector<std::uint32_t> inliers;
  for (std::uint32_t i : members) {
    if (std::abs(plane.Height_m(points.points[i])) <= kGate_sigma * points.sigma_m[i]) {
      inliers.push_back(i);
    }
  }
  return inliers;
}

std::optional<Plane> RefinePlane(const Plane& start, const OrientedPoints& points,
                                 std::span<const std::uint32_t> members) {
  Plane plane = start;
  for (int round = 0; round < kRefinements; ++round) {
    const std::vector<std::uint32_t> inliers = Inliers(plane, points, members);
    if (inliers.size() < 3) return std::nullopt;
    const Vector3 origin = points.points[inliers[0]].cast<double>();
    Vector3 sum = Vector3::Zero();
    Matrix3 products = Matrix3::Zero();
    double weights = 0;
    for (std::uint32_t i : inliers) {
      const double weight = 1 / (double{points.sigma_m[i]} * points.sigma_m[i]);
      const Vector3 q = points.points[i].cast<double>() - origin;
      sum += weight * q;
      products += weight * q * q.transpose();
      weights += weight;
    }
    const Vector3 mean = sum / weights;
    const Matrix3 covariance = products / weights - mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Matrix3> solver(covariance);
    if (solver.eigenvalues()(1) < 1e-12) return std::nullopt;  // on a line
    Vector3 normal = solver.eigenvectors().col(0);
    if (normal.dot(plane.normal) < 0) normal = -normal;
    plane = {normal, normal.dot(origin + mean)};
  }
  return plane;
}

std::optional<Plane> FitPlane(const OrientedPoints& points, std::span<const std::uint32_t> members,
                              std::uint64_t seed) {
  if (members.size() < 3) return std::nullopt;
  std::optional<Plane> best;
  double best_cost = 0;
  for (int t = 0; t < kTriples; ++t) {
    std::uint32_t triple[3];
    for (std::uint32_t& i : triple) i = members[NextRandomBits(seed) % members.size()];
    const std::optional<Plane> plane = PlaneOfTriple(points, triple);
    if (!plane) continue;
    const double cost = Cost(*plane, points, members);
    if (!best || cost < best_cost) best = plane, best_cost = cost;
  }
  return best ? RefinePlane(*best, points, members) : std::nullopt;
}

}  // namespace cwm::perception
