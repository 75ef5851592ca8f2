#include "perception/live/robot_silhouette.h"

#include <algorithm>
#include <cmath>

namespace cwm::perception {
namespace {

constexpr std::int16_t kFarFromOutline = std::numeric_limits<std::int16_t>::max();

// Twice the signed area of (a, b, p) on the image, whose v points down.
float EdgeFunction(const Eigen::Vector3f& a, const Eigen::Vector3f& b, float u, float v) {
  return (b.x() - a.x()) * (v - a.y()) - (b.y() - a.y()) * (u - a.x());
}

int ClampedCell(float cell, int count) {
  return static_cast<int>(std::clamp(cell, 0.0F, static_cast<float>(count)));
}

}  // namespace

void RobotSilhouette::Reset(const DepthCamera& camera) {
  constexpr auto kCell = static_cast<float>(kSilhouetteCell_px);
  columns_ = (camera.width + kSilhouetteCell_px - 1) / kSilhouetteCell_px;
  rows_ = (camera.height + kSilhouetteCell_px - 1) / kSilhouetteCell_px;
  // The centre of the first cell is (0, 0); that of its first pixel is half a pixel less.
  constexpr float kShift_px = 0.5F * (kCell - 1);
  focal_u_ = static_cast<float>(camera.pinhole.focal_u_px) / kCell;
  focal_v_ = static_cast<float>(camera.pinhole.focal_v_px) / kCell;
  center_u_ = (static_cast<float>(camera.pinhole.center_u_px) - kShift_px) / kCell;
  center_v_ = (static_cast<float>(camera.pinhole.center_v_px) - kShift_px) / kCell;
  near_m_.assign(static_cast<std::size_t>(columns_) * rows_, kNothing_m);
  body_.assign(near_m_.size(), -1);
}

void RobotSilhouette::Draw(const LinkSurface& surface, const Pose& X_CL, std::int16_t body) {
  const Eigen::Matrix3f R_CL = X_CL.linear().cast<float>();
  const Eigen::Vector3f t_CL = X_CL.translation().cast<float>();
  corners_C_.clear();
  projections_.clear();
  for (const Eigen::Vector3f& p_L : surface.vertices_L()) {
    const Eigen::Vector3f p = R_CL * p_L + t_CL;
    const float inverse_z = 1 / p.z();
    corners_C_.push_back(p);
    projections_.emplace_back(focal_u_ * p.x() * inverse_z + center_u_,
                              focal_v_ * p.y() * inverse_z + center_v_, inverse_z);
  }
  for (const LinkSurface::Triangle& triangle : surface.triangles()) {
    const auto [a, b, c] = triangle.corners;
    const float least_z = std::min({corners_C_[a].z(), corners_C_[b].z(), corners_C_[c].z()});
    if (least_z >= kNearPlane_m) {
      DrawTriangle(projections_[a], projections_[b], projections_[c], triangle.two_sided, body);
    } else {
      DrawClipped({corners_C_[a], corners_C_[b], corners_C_[c]}, triangle.two_sided, body);
    }
  }
}

void RobotSilhouette::DrawClipped(const std::array<Eigen::Vector3f, 3>& corners_C, bool two_sided,
                                  std::int16_t body) {
  std::array<Eigen::Vector3f, 4> kept;  // a triangle cut by a plane has at most four corners
  std::size_t count = 0;
  const auto keep = [&](const Eigen::Vector3f& p) {
    kept[count++] = {focal_u_ * p.x() / p.z() + center_u_, focal_v_ * p.y() / p.z() + center_v_,
                     1 / p.z()};
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3f& from = corners_C[i];
    const Eigen::Vector3f& to = corners_C[(i + 1) % 3];
    const bool is_kept = from.z() >= kNearPlane_m;
    if (is_kept) keep(from);
    if (is_kept != (to.z() >= kNearPlane_m)) {
      const float share = (kNearPlane_m - from.z()) / (to.z() - from.z());
      Eigen::Vector3f cut = from + share * (to - from);
      cut.z() = kNearPlane_m;
      keep(cut);
    }
  }
  for (std::size_t i = 2; i < count; ++i) {
    DrawTriangle(kept[0], kept[i - 1], kept[i], two_sided, body);
  }
}

void RobotSilhouette::DrawTriangle(const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                                   const Eigen::Vector3f& c, bool two_sided, std::int16_t body) {
  // Counter-clockwise corners seen from outside are clockwise on an image whose v points down if
  // u points right: the area is negative in the frame of the image for triangles that face it.
  const float area = EdgeFunction(a, b, c.x(), c.y());
  if (area == 0 || (area > 0 && !two_sided) || !std::isfinite(area)) return;
  const float sign = area > 0 ? 1.0F : -1.0F;
  const int column_begin = ClampedCell(std::ceil(std::min({a.x(), b.x(), c.x()})), columns_);
  const int column_end = ClampedCell(std::floor(std::max({a.x(), b.x(), c.x()})) + 1, columns_);
  const int row_begin = ClampedCell(std::ceil(std::min({a.y(), b.y(), c.y()})), rows_);
  const int row_end = ClampedCell(std::floor(std::max({a.y(), b.y(), c.y()})) + 1, rows_);
  // 1 / z and the three edge functions are linear in u and v.
  const auto slope_u = [&](const Eigen::Vector3f& p, const Eigen::Vector3f& q) {
    return -sign * (q.y() - p.y());
  };
  const float step_a = slope_u(b, c), step_b = slope_u(c, a), step_c = slope_u(a, b);
  const float scale = 1 / std::abs(area);
  const auto u0 = static_cast<float>(column_begin);
  for (int row = row_begin; row < row_end; ++row) {
    const auto v = static_cast<float>(row);
    const float row_a = sign * EdgeFunction(b, c, u0, v);
    const float row_b = sign * EdgeFunction(c, a, u0, v);
    const float row_c = sign * EdgeFunction(a, b, u0, v);
    const std::size_t first = static_cast<std::size_t>(row) * columns_;
    for (int column = column_begin; column < column_end; ++column) {
      const auto du = static_cast<float>(column - column_begin);
      const float weight_a = row_a + du * step_a;
      const float weight_b = row_b + du * step_b;
      const float weight_c = row_c + du * step_c;
      if (weight_a < 0 || weight_b < 0 || weight_c < 0) continue;
      const float inverse_z = scale * (weight_a * a.z() + weight_b * b.z() + weight_c * c.z());
      const float depth_m = 1 / inverse_z;
      const std::size_t cell = first + static_cast<std::size_t>(column);
      if (!(depth_m < near_m_[cell])) continue;
      near_m_[cell] = depth_m;
      body_[cell] = body;
    }
  }
}

std::vector<std::int16_t> RobotSilhouette::CellsToOutline() const {
  // A border of cells that are far from any outline spares tests of the image's edge.
  const int stride = columns_ + 2;
  std::vector<std::int16_t> padded(static_cast<std::size_t>(stride) * (rows_ + 2), kFarFromOutline);
  std::vector<std::int16_t> cells(near_m_.size());
  const auto least_of = [](std::int16_t a, std::int16_t b, std::int16_t c, std::int16_t d) {
    return std::min(std::min(a, b), std::min(c, d));
  };
  // Two passes over the neighbours before and after a cell are exact for this distance (Rosenfeld
  // and Pfaltz 1966).
  for (int row = 0; row < rows_; ++row) {
    std::int16_t* at = padded.data() + static_cast<std::size_t>(row + 1) * stride + 1;
    const std::int16_t* drawn = body_.data() + static_cast<std::size_t>(row) * columns_;
    for (int i = 0; i < columns_; ++i) {
      const std::int16_t least =
          least_of(at[i - 1], at[i - 1 - stride], at[i - stride], at[i + 1 - stride]);
      at[i] =
          static_cast<std::int16_t>(drawn[i] < 0 ? 0 : std::min<int>(least + 1, kFarFromOutline));
    }
  }
  for (int row = rows_ - 1; row >= 0; --row) {
    std::int16_t* at = padded.data() + static_cast<std::size_t>(row + 1) * stride + 1;
    for (int i = columns_ - 1; i >= 0; --i) {
      const std::int16_t least =
          least_of(at[i + 1], at[i + 1 + stride], at[i + stride], at[i - 1 + stride]);
      at[i] = static_cast<std::int16_t>(std::min<int>(at[i], least + 1));
    }
    std::copy(at, at + columns_, cells.data() + static_cast<std::size_t>(row) * columns_);
  }
  return cells;
}

void DilateNearest(int columns, int radius, std::vector<float>& near_m) {
  if (columns == 0 || radius == 0) return;
  const int rows = static_cast<int>(near_m.size()) / columns;
  std::vector<float> along_rows = near_m;
  for (int row = 0; row < rows; ++row) {
    float* to = along_rows.data() + static_cast<std::size_t>(row) * columns;
    const float* from = near_m.data() + static_cast<std::size_t>(row) * columns;
    for (int shift = 1; shift <= std::min(radius, columns - 1); ++shift) {
      for (int i = 0; i < columns - shift; ++i) {
        to[i] = std::min(to[i], from[i + shift]);
        to[i + shift] = std::min(to[i + shift], from[i]);
      }
    }
  }
  near_m = along_rows;
  for (int shift = 1; shift <= std::min(radius, rows - 1); ++shift) {
    const std::size_t step = static_cast<std::size_t>(shift) * columns;
    for (std::size_t i = 0; i + step < near_m.size(); ++i) {
      near_m[i] = std::min(near_m[i], along_rows[i + step]);
      near_m[i + step] = std::min(near_m[i + step], along_rows[i]);
    }
  }
}

}  // namespace cwm::perception
