#include "perception/cloud/normals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>

#include "perception/cloud/parallel_for.h"
#include "perception/cloud/window_normals.h"

namespace cwm::perception {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;

using namespace std::chrono_literals;

// adj(C) = det(C) C^-1 of a symmetric matrix; defined also if C is singular.
Matrix3f Adjugate(const Matrix3f& c) {
  Matrix3f a;
  a.col(0) = c.col(1).cross(c.col(2));
  a.col(1) = c.col(2).cross(c.col(0));
  a.col(2) = c.col(0).cross(c.col(1));
  return a;
}

// The unit normal n that minimises n^T C n for fixed n . ray (noise along the ray): n ~ C^-1 ray.
// Each further application of C^-1 moves it toward the eigenvector of the smallest eigenvalue, for
// clouds in which the ray is not the direction of the noise. Zero if the points lie on a line.
Vector3f NormalOf(const Matrix3f& covariance, const Vector3f& ray, int iterations) {
  const float scale = covariance.trace();
  if (!(scale > 0)) return Vector3f::Zero();
  const Matrix3f inverse = Adjugate(covariance / scale);
  // The two smaller eigenvalues of a line are rounding errors.
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

PointPlanes PlanesOf(const MeasuredPoints& measured, const Work& work) {
  const int width = measured.width, height = measured.height;
  PointPlanes planes{.width = width,
                     .height = height,
                     .pixel_angle_rad = measured.pixel_angle_rad,
                     .sample_px = std::sqrt(measured.oriented.points_per_sample),
                     .x = {width, height},
                     .y = {width, height},
                     .z = {width, height},
                     .sigma_m = {width, height}};
  ForEachPixel(measured, work, [&](std::size_t i, int row, int column) {
    planes.x.Row(row)[column] = measured.oriented.points[i].x();
    planes.y.Row(row)[column] = measured.oriented.points[i].y();
    planes.z.Row(row)[column] = measured.oriented.points[i].z();
    planes.sigma_m.Row(row)[column] = measured.oriented.sigma_m[i];
  });
  return planes;
}

// Assigns the normals of a row to its points, except to those with given normals.
void TakeOver(const RowNormals& normals, std::span<const std::int32_t> line,
              OrientedPoints& points) {
  for (std::size_t column = 0; column < line.size(); ++column) {
    if (line[column] < 0) continue;
    const auto i = static_cast<std::size_t>(line[column]);
    points.normal_sigma_rad[i] = normals.sigma_rad[column];
    if (points.normals[i].isZero()) {
      points.normals[i] = {normals.x[column], normals.y[column], normals.z[column]};
    } else {
      TurnToSensor(points.normals[i], points.points[i]);
    }
  }
}

}  // namespace

float NormalSigma_rad(float sigma_m, float radius_m, float sample_count) {
  const float independent = std::max(1.0f, sample_count);
  return std::min(kUnknownSigma_rad, 2 * sigma_m / (radius_m * std::sqrt(independent)));
}

void EstimateImageNormals(MeasuredPoints& measured, const Work& work) {
  const PointPlanes planes = PlanesOf(measured, work);
  OrientedPoints& points = measured.oriented;
  const auto width = static_cast<std::size_t>(measured.width);
  // A row of 640 pixels takes 0.05 ms.
  ParallelFor(static_cast<std::size_t>(measured.height),
              ItemsPerChunk(80ns * std::max(measured.width, 1)), work,
              [&](std::size_t begin, std::size_t end) {
                RowNormals normals(measured.width);
                for (std::size_t row = begin; row < end; ++row) {
                  EstimateRow(planes, static_cast<int>(row), normals);
                  TakeOver(normals, {measured.image.data() + row * width, width}, points);
                }
              });
}

void EstimateGridNormals(OrientedPoints& points, const VoxelGrid& grid, float radius_m,
                         const Work& work) {
  // chosen: views from elsewhere may be merged in, so the ray is only a start value, whose
  // influence each iteration reduces by the ratio of the eigenvalues.
  constexpr int kPowerIterations = 4;
  const int reach = static_cast<int>(std::ceil(radius_m / grid.edge_m()));
  auto estimate_cell = [&](std::size_t c) {
    const Vector3f centroid = grid.Centroid(c);
    Moments moments;
    grid.ForEachWithin(reach, grid.cell(c), [&](std::size_t o) {
      if ((grid.Centroid(o) - centroid).squaredNorm() > radius_m * radius_m) return;
      moments.Add(grid.moments(o), grid.Center(o) - centroid);
    });
    const Vector3f ray = centroid.normalized();
    Vector3f normal = Vector3f::Zero();
    if (moments.count >= 3) normal = NormalOf(moments.Covariance(), ray, kPowerIterations);
    for (std::uint32_t i : grid.PointsOf(c)) {
      points.normal_sigma_rad[i] =
          NormalSigma_rad(points.sigma_m[i], radius_m,
                          static_cast<float>(moments.count) / points.points_per_sample);
      if (points.normals[i].isZero()) points.normals[i] = normal;
      TurnToSensor(points.normals[i], points.points[i]);
    }
  };
  ParallelFor(grid.size(), ItemsPerChunk(2us), work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) estimate_cell(c);
  });
}

}  // namespace cwm::perception
