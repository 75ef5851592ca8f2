#include "perception/cloud/window_normals.h"

#include <algorithm>
#include <numbers>

#include "perception/cloud/lanes.h"
#include "perception/cloud/normals.h"
#include "perception/cloud/sensor_noise.h"

namespace cwm::perception {
namespace {

using IntLanes = LaneMask;

// measured: 7 x 7 pixels of a window carry what all of them do, unless pixels nearer to each other
// err each by itself.
constexpr int kSamplesAcrossRadius = 3;
// derived: how far apart neighbours lie on a surface that is slanted as much.
constexpr float kMaxSlant = static_cast<float>(1 / kSteepIncidence_cos);

struct Vectors {
  Lanes x, y, z;
};

CWM_LANES_INLINE Lanes Dot(const Vectors& a, const Vectors& b) {
  return a.x * b.x + (a.y * b.y + a.z * b.z);
}

// Of a symmetric matrix, or the sums of products of coordinates.
struct Symmetric {
  Lanes xx, xy, xz, yy, yz, zz;
};

CWM_LANES_INLINE Vectors operator*(const Symmetric& m, const Vectors& v) {
  return {m.xx * v.x + (m.xy * v.y + m.xz * v.z), m.xy * v.x + (m.yy * v.y + m.yz * v.z),
          m.xz * v.x + (m.yz * v.y + m.zz * v.z)};
}

// det(C) C^-1; defined also where C is singular.
CWM_LANES_INLINE Symmetric Adjugate(const Symmetric& c) {
  return {c.yy * c.zz - c.yz * c.yz, c.yz * c.xz - c.zz * c.xy, c.xy * c.yz - c.xz * c.yy,
          c.zz * c.xx - c.xz * c.xz, c.xz * c.xy - c.xx * c.yz, c.xx * c.yy - c.xy * c.xy};
}

// Of the neighbours of each pixel, about the pixel's own point.
struct WindowSums {
  Vectors sum{};
  Symmetric products{};
  Lanes count{};
};

struct Windows {
  IntLanes radius_px, step_px;
};

CWM_LANES_INLINE Windows WindowsOf(const Lanes& radius_m, const Lanes& pixel_m, int most_step_px) {
  Windows windows;
  for (int k = 0; k < kLanes; ++k) {
    // Without a point px is NaN, which std::max drops.
    const float px = std::min(std::max(kMinWindow_px, radius_m[k] / pixel_m[k]), kMaxWindow_px);
    // px / kSamplesAcrossRadius, rounded.
    const int step =
        std::clamp(static_cast<int>((2 * px + kSamplesAcrossRadius) / (2 * kSamplesAcrossRadius)),
                   1, most_step_px);
    windows.step_px[k] = step;
    windows.radius_px[k] = std::max(step, static_cast<int>(px) / step * step);
  }
  return windows;
}

// The sums of one window, the same for all lanes, around the pixels from `column` on.
CWM_LANES_INLINE void AddWindow(const PointPlanes& points, int row, int column, int radius_px,
                                int step_px, const Vectors& p, const Lanes& reach_m2,
                                const LaneMask& wanted, WindowSums& sums) {
  const int top = std::max(row - radius_px, row % step_px);
  const int bottom = std::min(row + radius_px, points.height - 1);
  for (int v = top; v <= bottom; v += step_px) {
    const float *xs = points.x.Row(v) + column, *ys = points.y.Row(v) + column,
                *zs = points.z.Row(v) + column;
    for (int u = -radius_px; u <= radius_px; u += step_px) {
      Vectors q{LoadLanes(xs + u) - p.x, LoadLanes(ys + u) - p.y, LoadLanes(zs + u) - p.z};
      const LaneMask counts = (Dot(q, q) <= reach_m2) & wanted;
      q = {Where(counts, q.x), Where(counts, q.y), Where(counts, q.z)};
      sums.sum = {sums.sum.x + q.x, sums.sum.y + q.y, sums.sum.z + q.z};
      Symmetric& s = sums.products;
      s = {s.xx + q.x * q.x, s.xy + q.x * q.y, s.xz + q.x * q.z,
           s.yy + q.y * q.y, s.yz + q.y * q.z, s.zz + q.z * q.z};
      sums.count += Where(counts, Lanes{} + 1.0f);
    }
  }
}

// The unit normal n that minimises n^T C n for fixed n . ray (noise along the ray): n ~ C^-1 ray.
// Zero where the points lie on a line. As NormalOf of normals.cc with one iteration.
CWM_LANES_INLINE Vectors NormalsOf(const WindowSums& sums, const Vectors& ray) {
  const Lanes& n = sums.count;
  const Vectors m{sums.sum.x / n, sums.sum.y / n, sums.sum.z / n};
  const Symmetric& s = sums.products;
  Symmetric c{s.xx / n - m.x * m.x, s.xy / n - m.x * m.y, s.xz / n - m.x * m.z,
              s.yy / n - m.y * m.y, s.yz / n - m.y * m.z, s.zz / n - m.z * m.z};
  const Lanes scale = c.xx + (c.yy + c.zz);
  c = {c.xx / scale, c.xy / scale, c.xz / scale, c.yy / scale, c.yz / scale, c.zz / scale};
  const Symmetric inverse = Adjugate(c);
  Vectors normal = inverse * ray;
  const Lanes norm = SquareRoots(Dot(normal, normal));
  normal = {normal.x / norm, normal.y / norm, normal.z / norm};
  // The two smaller eigenvalues of a line are noise of the arithmetic.
  const LaneMask known = (n >= 3.0f) & (scale > 0.0f) &
                         (inverse.xx + (inverse.yy + inverse.zz) >= 1e-5f) & (norm > 1e-12f);
  const LaneMask away = Dot(normal, ray) > 0.0f;
  const Lanes turn = Where(away, Lanes{} - 1.0f) + Where(~away, Lanes{} + 1.0f);
  return {Where(known, normal.x * turn), Where(known, normal.y * turn),
          Where(known, normal.z * turn)};
}

// NormalSigma_rad of normals.cc.
CWM_LANES_INLINE Lanes SigmasOf(const Lanes& sigma_m, const Lanes& radius_m,
                                const Lanes& sample_count) {
  Lanes independent = sample_count;
  for (int k = 0; k < kLanes; ++k) independent[k] = std::max(1.0f, independent[k]);
  Lanes sigma_rad = 2.0f * sigma_m / (radius_m * SquareRoots(independent));
  for (int k = 0; k < kLanes; ++k) sigma_rad[k] = std::min(kUnknownSigma_rad, sigma_rad[k]);
  return sigma_rad;
}

// Two points of a surface that lie the radius apart differ by three deviations of either's noise
// besides; never farther than a radius that follows from noise alone.
CWM_LANES_INLINE Lanes ReachesOf(const Lanes& radius_m, const Lanes& sigma_m) {
  const Lanes apart_m = SquareRoots(radius_m * radius_m + 9.0f * sigma_m * sigma_m);
  return Lesser(kNormalRadius_sigma * sigma_m, apart_m);
}

CWM_LANES_INLINE void EstimateBlock(const PointPlanes& points, int row, int column,
                                    RowNormals& normals) {
  const Vectors p{LoadLanes(points.x.Row(row) + column), LoadLanes(points.y.Row(row) + column),
                  LoadLanes(points.z.Row(row) + column)};
  const Lanes sigma_m = LoadLanes(points.sigma_m.Row(row) + column);
  const Lanes range_m = SquareRoots(Dot(p, p));
  const Lanes pixel_m = range_m * points.pixel_angle_rad;
  const Lanes of_noise_m = NormalRadii_m(sigma_m, points.sample_px * pixel_m);
  const Lanes radius_m = Greater(of_noise_m, kMinWindow_px * pixel_m);
  const Lanes reach_m = std::numbers::sqrt2_v<float> * Greater(ReachesOf(of_noise_m, sigma_m),
                                                               kMaxSlant * kMinWindow_px * pixel_m);
  const Windows windows =
      WindowsOf(radius_m, pixel_m, std::max(1, static_cast<int>(points.sample_px)));
  // Neighbours mostly have windows of one size: each size is summed once, for all who have it.
  LaneMask waiting = range_m >= Lanes{};  // not where there is no point
  WindowSums sums;
  Lanes density{};  // pixels that a sample stands for
  for (int k = 0; k < kLanes; ++k) {
    if (!waiting[k]) continue;
    const int radius_px = windows.radius_px[k], step_px = windows.step_px[k];
    const LaneMask same = waiting & (windows.radius_px == radius_px) & (windows.step_px == step_px);
    AddWindow(points, row, column, radius_px, step_px, p, reach_m * reach_m, same, sums);
    density += Where(same, Lanes{} + static_cast<float>(step_px * step_px));
    waiting &= ~same;
  }
  const Vectors ray{p.x / range_m, p.y / range_m, p.z / range_m};
  const Vectors normal = NormalsOf(sums, ray);
  const auto at = static_cast<std::size_t>(column);
  StoreLanes(normal.x, &normals.x[at]);
  StoreLanes(normal.y, &normals.y[at]);
  StoreLanes(normal.z, &normals.z[at]);
  StoreLanes(
      SigmasOf(sigma_m, radius_m, sums.count * density / (points.sample_px * points.sample_px)),
      &normals.sigma_rad[at]);
}

CWM_LANES_INLINE void EstimateBlocks(const PointPlanes& points, int row, RowNormals& normals) {
  for (int column = 0; column < points.width; column += kLanes) {
    EstimateBlock(points, row, column, normals);
  }
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void EstimateWide(const PointPlanes& points, int row,
                                                  RowNormals& normals) {
  EstimateBlocks(points, row, normals);
}
#endif

}  // namespace

RowNormals::RowNormals(int width) {
  const auto size = static_cast<std::size_t>(width) + kLanes;
  for (std::vector<float>* values : {&x, &y, &z, &sigma_rad}) values->resize(size);
}

void EstimateRow(const PointPlanes& points, int row, RowNormals& normals) {
#if defined(__x86_64__)
  if (HasWideLanes()) return EstimateWide(points, row, normals);
#endif
  EstimateBlocks(points, row, normals);
}

}  // namespace cwm::perception
