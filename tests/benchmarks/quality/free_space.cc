#include "tests/benchmarks/quality/free_space.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "collision/geometry/signed_distance.h"
#include "tests/benchmarks/quality/cell_index.h"

namespace cwm::benchmarks {
namespace {

constexpr double kBeforeHit_m = 0.030;
constexpr double kDeep_m = 0.010;
// The shortest step along a ray: a part that is thinner across the ray is stepped over.
constexpr double kMinStep_m = 0.0005;
// A grazing ray stays clear of its hit by at most ten times as much: beyond 84 degrees hardly any
// sensor measures, and the estimate of the angle is useless.
constexpr double kMinCosine = 0.1;

// The part of a ray from the sensor that was seen to be free.
struct FreeRay {
  Vector3 direction_C = Vector3::UnitZ();  // unit
  double length_m = 0;
};

class Cloud {
 public:
  Cloud(const perception::PointCloud& cloud, const OtherMeasurements& other)
      : cloud_(cloud),
        noise_(other.noise),
        before_sigma_(other.before_sigma),
        measured_(other.points) {
    measured_.insert(measured_.end(), cloud.points.begin(), cloud.points.end());
    for (std::uint32_t i = 0; i < measured_.size(); ++i) {
      if (!measured_[i].allFinite()) continue;
      const Vector3 p_C = measured_[i].cast<double>();
      index_.Insert(Aabb(p_C, p_C), i);
    }
  }

  std::optional<FreeRay> RayTo(int u, int v) const {
    const std::optional<Vector3> hit_C = At(u, v);
    if (!hit_C) return std::nullopt;
    const double range_m = hit_C->norm();
    const Vector3 direction_C = *hit_C / range_m;
    const double cosine = std::abs(NormalAt(u, v, *hit_C).dot(direction_C));
    const double before_m = std::max(kBeforeHit_m, before_sigma_ * noise_.AxialSigma_m(hit_C->z()));
    const double length_m = range_m - before_m / std::max(cosine, kMinCosine);
    if (length_m <= 0) return std::nullopt;
    return FreeRay{direction_C, length_m};
  }

  bool IsMeasuredNear(const Vector3& p_C) const {
    const double tolerance_m = ToleranceAt_m(p_C);
    return index_.AnyNear(p_C, tolerance_m, [&](std::uint32_t i) {
      return (measured_[i].cast<double>() - p_C).norm() <= tolerance_m;
    });
  }

 private:
  double ToleranceAt_m(const Vector3& p_C) const {
    return perception::ExplainedWithin_m(noise_.AxialSigma_m(p_C.z()));
  }

  std::optional<Vector3> At(int u, int v) const {
    if (u < 0 || v < 0 || u >= cloud_.width || v >= cloud_.height) return std::nullopt;
    const Eigen::Vector3f& p = cloud_.points[static_cast<std::size_t>(v) * cloud_.width + u];
    if (!p.allFinite()) return std::nullopt;
    return p.cast<double>();
  }

  // The normal of the plane through the neighbours on the same surface; towards the sensor if there
  // are none.
  Vector3 NormalAt(int u, int v, const Vector3& hit_C) const {
    constexpr int kHalfWindow = 4;
    const double same_surface_m = 0.02 + ToleranceAt_m(hit_C);
    Vector3 mean = Vector3::Zero();
    Matrix3 square = Matrix3::Zero();
    int count = 0;
    for (int dv = -kHalfWindow; dv <= kHalfWindow; ++dv) {
      for (int du = -kHalfWindow; du <= kHalfWindow; ++du) {
        const std::optional<Vector3> p_C = At(u + du, v + dv);
        if (!p_C || std::abs(p_C->z() - hit_C.z()) > same_surface_m) continue;
        const Vector3 d = *p_C - hit_C;
        mean += d;
        square += d * d.transpose();
        ++count;
      }
    }
    constexpr int kEnough = 12;
    if (count < kEnough) return hit_C.normalized();
    mean /= count;
    const Matrix3 covariance = square / count - mean * mean.transpose();
    return Eigen::SelfAdjointEigenSolver<Matrix3>(covariance).eigenvectors().col(0);
  }

  const perception::PointCloud& cloud_;
  const perception::SensorNoise noise_;
  const double before_sigma_;
  std::vector<Eigen::Vector3f> measured_;
  CellIndex index_;
};

enum class Meeting { kNone, kDeep, kCrossing };

// The part of the ray inside the bounds, as t_min and t_max; empty if it misses them.
std::optional<Vector2> Clip(const FreeRay& ray, const Aabb& bounds_C) {
  double low = 0, high = ray.length_m;
  for (Eigen::Index a = 0; a < 3; ++a) {
    const double d = ray.direction_C[a];
    if (d == 0) {
      if (bounds_C.min()[a] > 0 || bounds_C.max()[a] < 0) return std::nullopt;
      continue;
    }
    const double t0 = bounds_C.min()[a] / d, t1 = bounds_C.max()[a] / d;
    low = std::max(low, std::min(t0, t1));
    high = std::min(high, std::max(t0, t1));
  }
  if (low > high) return std::nullopt;
  return Vector2(low, high);
}

// Steps along the ray by the distance to the surface, which no step can overshoot.
Meeting Walk(const FreeRay& ray, const ClaimedSolid& solid, const Cloud& cloud) {
  const std::optional<Vector2> inside = Clip(ray, solid.bounds_C);
  if (!inside) return Meeting::kNone;
  const Pose X_SC = solid.X_CS.inverse();
  const auto distance_m = [&](double t) {
    return SignedDistance_m(solid.shape, X_SC * (t * ray.direction_C));
  };
  // Begins just before the bounds: entering through a face that lies in them is a crossing too.
  double t = std::max(0.0, inside->x() - kMinStep_m);
  double before_m = distance_m(t);
  while (true) {
    if (before_m < -kDeep_m) return Meeting::kDeep;
    const double next = t + std::max(std::abs(before_m), kMinStep_m);
    if (next > inside->y() + kMinStep_m || next > ray.length_m) return Meeting::kNone;
    const double now_m = distance_m(next);
    if ((now_m < 0) != (before_m < 0) && !cloud.IsMeasuredNear(next * ray.direction_C)) {
      return Meeting::kCrossing;
    }
    t = next;
    before_m = now_m;
  }
}

// The ray parameter at which the ray meets the triangle (Moeller and Trumbore 1997); empty if it
// misses.
std::optional<double> Cross(const FreeRay& ray, const ClaimedTriangle& triangle) {
  const auto& [a, b, c] = triangle.corners_C;
  const Vector3 e1 = b - a, e2 = c - a;
  const Vector3 p = ray.direction_C.cross(e2);
  const double determinant = e1.dot(p);
  if (determinant == 0) return std::nullopt;
  const double u = -a.dot(p) / determinant;
  const Vector3 q = -a.cross(e1);
  const double v = ray.direction_C.dot(q) / determinant;
  if (u < 0 || v < 0 || u + v > 1) return std::nullopt;
  const double t = e2.dot(q) / determinant;
  if (t <= 0 || t > ray.length_m) return std::nullopt;
  return t;
}

// Triangles, indexed by the image tiles in which they may appear.
class TriangleImage {
 public:
  TriangleImage(const std::vector<ClaimedTriangle>& triangles,
                const perception::PinholeCamera& camera)
      : camera_(camera),
        columns_(camera.width / kTile_px + 1),
        rows_(camera.height / kTile_px + 1),
        tiles_(static_cast<std::size_t>(columns_) * rows_) {
    for (std::uint32_t t = 0; t < triangles.size(); ++t) Insert(triangles[t], t);
  }

  const std::vector<std::uint32_t>& At(int u, int v) const {
    return tiles_[static_cast<std::size_t>(v / kTile_px) * columns_ + u / kTile_px];
  }

 private:
  static constexpr int kTile_px = 8;
  static constexpr double kMargin_px = 1.5;  // points lie on their pixels' rays up to rounding
  static constexpr double kNear_m = 0.05;

  void Insert(const ClaimedTriangle& triangle, std::uint32_t id) {
    Eigen::AlignedBox2d seen(Vector2(0, 0), Vector2(camera_.width - 1, camera_.height - 1));
    Eigen::AlignedBox2d bounds;
    bool behind = false;
    for (const Vector3& p : triangle.corners_C) {
      behind = behind || p.z() < kNear_m;
      const Vector2 pixel(camera_.center_x_px + camera_.focal_px * p.x() / p.z(),
                          camera_.center_y_px + camera_.focal_px * p.y() / p.z());
      bounds.extend(pixel);
    }
    const Vector2 margin = Vector2::Constant(kMargin_px);
    if (!behind) seen = seen.intersection({bounds.min() - margin, bounds.max() + margin});
    if (seen.isEmpty()) return;
    for (int row = Tile(seen.min().y()); row <= Tile(seen.max().y()); ++row) {
      for (int column = Tile(seen.min().x()); column <= Tile(seen.max().x()); ++column) {
        tiles_[static_cast<std::size_t>(row) * columns_ + column].push_back(id);
      }
    }
  }
  static int Tile(double px) { return static_cast<int>(px) / kTile_px; }

  const perception::PinholeCamera& camera_;
  int columns_, rows_;
  std::vector<std::vector<std::uint32_t>> tiles_;
};

// Counts the ray, and counts it as violating if it meets a claim.
void Judge(const FreeRay& ray, const ClaimedGeometry& claims,
           const std::vector<std::uint32_t>& triangles, const Cloud& cloud, FreeSpace& result) {
  ++result.rays;
  for (const ClaimedSolid& solid : claims.solids) {
    const Meeting meeting = Walk(ray, solid, cloud);
    if (meeting == Meeting::kNone) continue;
    auto& counts = meeting == Meeting::kDeep ? result.deep : result.crossed;
    ++counts[static_cast<std::size_t>(solid.claim)];
    ++result.violating;
    return;
  }
  for (std::uint32_t t : triangles) {
    const std::optional<double> at_m = Cross(ray, claims.triangles[t]);
    if (!at_m || cloud.IsMeasuredNear(*at_m * ray.direction_C)) continue;
    ++result.crossed[static_cast<std::size_t>(claims.triangles[t].claim)];
    ++result.violating;
    return;
  }
}

}  // namespace

void FreeSpace::Add(const FreeSpace& other) {
  rays += other.rays;
  violating += other.violating;
  for (std::size_t c = 0; c < kClaimCount; ++c) {
    deep[c] += other.deep[c];
    crossed[c] += other.crossed[c];
  }
}

FreeSpace MeasureFreeSpace(const ClaimedGeometry& claims, const perception::PointCloud& cloud,
                           const perception::PinholeCamera& camera, int stride,
                           const OtherMeasurements& other) {
  const Cloud measured(cloud, other);
  const TriangleImage triangles(claims.triangles, camera);
  FreeSpace result;
  for (int v = 0; v < cloud.height; v += stride) {
    for (int u = 0; u < cloud.width; u += stride) {
      const std::optional<FreeRay> ray = measured.RayTo(u, v);
      if (ray) Judge(*ray, claims, triangles.At(u, v), measured, result);
    }
  }
  return result;
}

}  // namespace cwm::benchmarks
