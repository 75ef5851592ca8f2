#include "perception/track/range_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/cloud/returns.h"

namespace cwm::perception {
namespace {

// Least squares fit of pixel = slope * ratio + offset.
class LineFit {
 public:
  void Add(double ratio, double pixel) {
    ++count_;
    sum_r_ += ratio;
    sum_p_ += pixel;
    sum_rr_ += ratio * ratio;
    sum_rp_ += ratio * pixel;
    sum_pp_ += pixel * pixel;
  }
  double Slope() const { return Covariance() / Spread(); }
  double Offset() const { return (sum_p_ - Slope() * sum_r_) / count_; }
  // Mean square error in pixels^2; NaN if all ratios are equal.
  double MeanSquare_px2() const {
    return (sum_pp_ - sum_p_ * sum_p_ / count_ - Slope() * Covariance()) / count_;
  }

 private:
  double Covariance() const { return sum_rp_ - sum_r_ * sum_p_ / count_; }
  double Spread() const { return sum_rr_ - sum_r_ * sum_r_ / count_; }

  double count_ = 0;
  double sum_r_ = 0;
  double sum_p_ = 0;
  double sum_rr_ = 0;
  double sum_rp_ = 0;
  double sum_pp_ = 0;
};

// chosen: the largest and the least number of cells per edge of a face of the cube, 0.35 and 1.4
// degrees each: unorganised clouds are seldom denser, and with fewer cells one would hold half an
// object.
constexpr int kMaxCube = 256;
constexpr int kMinCube = 64;

Matrix3 Axes(const Vector3& x, const Vector3& y, const Vector3& z) {
  Matrix3 rotation;
  rotation << x.transpose(), y.transpose(), z.transpose();
  return rotation;
}

}  // namespace

void SightCounts::Add(RayVerdict verdict) {
  switch (verdict) {
    case RayVerdict::kUnknown:
      ++unknown;
      break;
    case RayVerdict::kHidden:
      ++hidden;
      break;
    case RayVerdict::kHit:
      ++hit;
      break;
    case RayVerdict::kThrough:
      ++through;
      break;
  }
}

double SightCounts::ThroughShare() const {
  return visible() > 0 ? static_cast<double>(through) / visible() : 0;
}

std::optional<Pinhole> EstimatePinhole(const PointCloud& cloud) {
  if (!cloud.organised()) return std::nullopt;
  LineFit columns;
  LineFit rows;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!IsReturn(cloud.points[i])) continue;
    const Vector3 p = cloud.points[i].cast<double>();
    if (p.z() <= 0) return std::nullopt;
    const auto column = i % cloud.width, row = i / cloud.width;
    columns.Add(p.x() / p.z(), static_cast<double>(column));
    rows.Add(p.y() / p.z(), static_cast<double>(row));
  }
  const bool fits = columns.MeanSquare_px2() < 1 && rows.MeanSquare_px2() < 1;  // to one pixel
  if (!fits) return std::nullopt;  // also if undefined (NaN)
  return Pinhole{.focal_u_px = columns.Slope(),
                 .focal_v_px = rows.Slope(),
                 .center_u_px = columns.Offset(),
                 .center_v_px = rows.Offset()};
}

RangeView::RangeView(const PointCloud& cloud) {
  if (const auto pinhole = EstimatePinhole(cloud)) {
    faces_.push_back({.R_FC = Matrix3::Identity(),
                      .pinhole = *pinhole,
                      .width = cloud.width,
                      .height = cloud.height,
                      .cells = {}});
  } else {
    AddCube(cloud.points.size());
  }
  constexpr float kFar = std::numeric_limits<float>::infinity();
  for (Face& face : faces_) {
    face.cells.assign(static_cast<std::size_t>(face.width) * face.height, {kFar, -kFar});
  }
  for (const Eigen::Vector3f& p : cloud.points) {
    if (IsReturn(p)) Insert(p);
  }
}

void RangeView::AddCube(std::size_t point_count) {
  const int cells = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(point_count)) / 2),
                               kMinCube, kMaxCube);
  const Vector3 x = Vector3::UnitX();
  const Vector3 y = Vector3::UnitY();
  const Vector3 z = Vector3::UnitZ();
  for (const Matrix3& R_FC : {Axes(x, y, z), Axes(-x, y, -z), Axes(y, z, x), Axes(-y, z, -x),
                              Axes(z, x, y), Axes(-z, x, -y)}) {
    // A face spans x / z from -1 to 1.
    const Pinhole pinhole{.focal_u_px = 0.5 * cells,
                          .focal_v_px = 0.5 * cells,
                          .center_u_px = 0.5 * (cells - 1),
                          .center_v_px = 0.5 * (cells - 1)};
    faces_.push_back(
        {.R_FC = R_FC, .pinhole = pinhole, .width = cells, .height = cells, .cells = {}});
  }
}

std::optional<RangeView::CellIndex> RangeView::Project(const Face& face, const Vector3& p_C) {
  const Vector3 p = face.R_FC * p_C;
  if (!(p.z() > 0)) return std::nullopt;
  const double u = face.pinhole.focal_u_px * p.x() / p.z() + face.pinhole.center_u_px;
  const double v = face.pinhole.focal_v_px * p.y() / p.z() + face.pinhole.center_v_px;
  if (!(u > -0.5 && u < face.width - 0.5 && v > -0.5 && v < face.height - 0.5)) {
    return std::nullopt;
  }
  return CellIndex{.u = static_cast<int>(std::lround(u)), .v = static_cast<int>(std::lround(v))};
}

void RangeView::Insert(const Eigen::Vector3f& p_C) {
  for (Face& face : faces_) {
    const auto index = Project(face, p_C.cast<double>());
    if (!index) continue;
    Cell& cell = face.cells[static_cast<std::size_t>(index->v) * face.width + index->u];
    cell.nearest_m = std::min(cell.nearest_m, p_C.norm());
    cell.farthest_m = std::max(cell.farthest_m, p_C.norm());
    return;
  }
}

RayVerdict RangeView::VerdictAt(const Vector3& p_C, double tolerance_m) const {
  const double range_m = p_C.norm();
  for (const Face& face : faces_) {
    const auto index = Project(face, p_C);
    if (!index) continue;
    double nearest_m = std::numeric_limits<double>::infinity();
    double farthest_m = -nearest_m;
    for (int v = std::max(0, index->v - 1); v <= std::min(face.height - 1, index->v + 1); ++v) {
      for (int u = std::max(0, index->u - 1); u <= std::min(face.width - 1, index->u + 1); ++u) {
        const Cell& cell = face.cells[static_cast<std::size_t>(v) * face.width + u];
        nearest_m = std::min<double>(nearest_m, cell.nearest_m);
        farthest_m = std::max<double>(farthest_m, cell.farthest_m);
      }
    }
    if (nearest_m > farthest_m) return RayVerdict::kUnknown;
    if (nearest_m > range_m + tolerance_m) return RayVerdict::kThrough;
    if (farthest_m < range_m - tolerance_m) return RayVerdict::kHidden;
    return RayVerdict::kHit;
  }
  return RayVerdict::kUnknown;
}

}  // namespace cwm::perception
