#include "perception/cloud/normals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/cloud/parallel_for.h"

namespace cwm::perception {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;

constexpr float kUnknownSigma_rad = std::numbers::pi_v<float> / 2;
constexpr int kSamplesAcrossRadius = 3;  // 7 x 7 pixels of a window carry what all of them do
// Pieces of less than a millisecond: measured, a pixel takes 0.3 us, a cell 2 us.
constexpr std::size_t kRowsPerPiece = 2;
constexpr std::size_t kCellsPerPiece = 256;

// adj(C) = det(C) C^-1 for a symmetric matrix; defined also where C is singular.
Matrix3f Adjugate(const Matrix3f& c) {
  Matrix3f a;
  a.col(0) = c.col(1).cross(c.col(2));
  a.col(1) = c.col(2).cross(c.col(0));
  a.col(2) = c.col(0).cross(c.col(1));
  return a;
}

// The unit normal n that minimises n^T C n for fixed n . ray (noise along the ray): n ~ C^-1 ray.
// Each further application of C^-1 moves it to the eigenvector of the smallest eigenvalue, where
// the ray says nothing about the noise. Zero where the points lie on a line.
Vector3f NormalOf(const Matrix3f& covariance, const Vector3f& ray, int iterations) {
  const float scale = covariance.trace();
  if (!(scale > 0)) return Vector3f::Zero();
  const Matrix3f inverse = Adjugate(covariance / scale);
  // The two smaller eigenvalues of a line are noise of the arithmetic.
  if (inverse.trace() < 1e-5f) return Vector3f::Zero();
  Vector3f n = ray;
  for (int i = 0; i < iterations; ++i) {
    n = inverse * n;
    const float norm = n.norm();
    if (!(norm > 1e-12f)) return Vector3f::Zero();
    n /= norm;
  }
  return n.dot(ray) > 0 ? Vector3f(-n) : n;
}

void TurnToSensor(Vector3f& normal, const Vector3f& point) {
  if (normal.dot(point) > 0) normal = -normal;
}

struct Window {
  int radius_px = 1;
  int step_px = 1;
};

Window WindowOf(float radius_m, float range_m, float pixel_angle_rad) {
  // A window beyond 64 pixels only occurs with the sensor on the surface.
  const float px = std::clamp(radius_m / std::max(range_m * pixel_angle_rad, 1e-6f), 1.0f, 64.0f);
  Window window;
  window.step_px = std::max(1, static_cast<int>(std::lround(px / kSamplesAcrossRadius)));
  window.radius_px =
      std::max(window.step_px, static_cast<int>(px) / window.step_px * window.step_px);
  return window;
}

Moments MomentsInWindow(const MeasuredPoints& measured, int row, int column, const Window& window,
                        const Vector3f& p, float radius_m) {
  Moments moments;
  const int top = std::max(row - window.radius_px, row % window.step_px);
  const int left = std::max(column - window.radius_px, column % window.step_px);
  const int bottom = std::min(row + window.radius_px, measured.height - 1);
  const int right = std::min(column + window.radius_px, measured.width - 1);
  for (int v = top; v <= bottom; v += window.step_px) {
    const std::int32_t* line =
        measured.image.data() + static_cast<std::ptrdiff_t>(v) * measured.width;
    for (int u = left; u <= right; u += window.step_px) {
      if (line[u] < 0) continue;
      const Vector3f q = measured.oriented.points[static_cast<std::size_t>(line[u])] - p;
      if (q.squaredNorm() <= radius_m * radius_m) moments.Add(q);
    }
  }
  return moments;
}

void EstimateAtPixel(MeasuredPoints& measured, int row, int column) {
  const std::int32_t index =
      measured.image[static_cast<std::size_t>(row) * static_cast<std::size_t>(measured.width) +
                     static_cast<std::size_t>(column)];
  if (index < 0) return;
  const auto i = static_cast<std::size_t>(index);
  OrientedPoints& points = measured.oriented;
  const Vector3f& p = points.points[i];
  // At a grazing view a window of the radius reaches farther than the radius: sqrt(2) of slack.
  const float radius = kNormalRadius_sigma * points.sigma_m[i];
  const Window window = WindowOf(radius, p.norm(), measured.pixel_angle_rad);
  const Moments moments =
      MomentsInWindow(measured, row, column, window, p, std::numbers::sqrt2_v<float> * radius);
  const float n = static_cast<float>(moments.count * window.step_px * window.step_px);
  points.normal_sigma_rad[i] = NormalSigma_rad(points.sigma_m[i], radius, n);
  if (!points.normals[i].isZero()) {
    TurnToSensor(points.normals[i], p);
    return;
  }
  if (moments.count < 3) return;
  points.normals[i] = NormalOf(moments.Covariance(), p.normalized(), 1);
}

}  // namespace

float NormalSigma_rad(float sigma_m, float radius_m, float point_count) {
  const float independent =
      std::max(1.0f, point_count / static_cast<float>(kPointsPerIndependentSample));
  return std::min(kUnknownSigma_rad, 2 * sigma_m / (radius_m * std::sqrt(independent)));
}

void EstimateImageNormals(MeasuredPoints& measured, const Work& work) {
  ParallelFor(static_cast<std::size_t>(measured.height), kRowsPerPiece, work,
              [&](std::size_t begin, std::size_t end) {
                for (std::size_t row = begin; row < end; ++row) {
                  for (int column = 0; column < measured.width; ++column) {
                    EstimateAtPixel(measured, static_cast<int>(row), column);
                  }
                }
              });
}

void EstimateGridNormals(OrientedPoints& points, const VoxelGrid& grid, float radius_m,
                         const Work& work) {
  constexpr int kIterations = 4;  // views from elsewhere may be merged in: the ray is only a start
  const int reach = static_cast<int>(std::ceil(radius_m / grid.edge_m()));
  auto estimate_cell = [&](std::size_t c) {
    const Vector3f centroid = grid.Centroid(c);
    Moments moments;
    VoxelGrid::Cell d;
    for (d.z() = -reach; d.z() <= reach; ++d.z()) {
      for (d.y() = -reach; d.y() <= reach; ++d.y()) {
        for (d.x() = -reach; d.x() <= reach; ++d.x()) {
          const std::int32_t other = grid.Find(grid.cell(c) + d);
          if (other == VoxelGrid::kNone) continue;
          const auto o = static_cast<std::size_t>(other);
          if ((grid.Centroid(o) - centroid).squaredNorm() > radius_m * radius_m) continue;
          moments.Add(grid.moments(o), grid.Center(o) - centroid);
        }
      }
    }
    const Vector3f ray = centroid.normalized();
    Vector3f normal = Vector3f::Zero();
    if (moments.count >= 3) normal = NormalOf(moments.Covariance(), ray, kIterations);
    for (std::uint32_t i : grid.PointsOf(c)) {
      points.normal_sigma_rad[i] =
          NormalSigma_rad(points.sigma_m[i], radius_m, static_cast<float>(moments.count));
      if (points.normals[i].isZero()) points.normals[i] = normal;
      TurnToSensor(points.normals[i], points.points[i]);
    }
  };
  ParallelFor(grid.size(), kCellsPerPiece, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) estimate_cell(c);
  });
}

}  // namespace cwm::perception
