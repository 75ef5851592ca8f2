#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "perception/cloud/window_normals.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include <algorithm>
#include <numbers>

#include "hwy/highway.h"
#include "perception/cloud/normal_radius-inl.h"
#include "perception/cloud/normals.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/cloud/window_normals.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::perception {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, kMaxLanes>;
using Lane = hn::Vec<Tag>;
using LaneMask = hn::Mask<Tag>;
constexpr Tag kTag;

// measured: 7 x 7 pixels of a window carry what all of them do, unless pixels nearer to each other
// err each by itself.
constexpr int kSamplesAcrossRadius = 3;
// derived: how far apart neighbours lie on a surface that is slanted as much.
constexpr float kMaxSlant = static_cast<float>(1 / kSteepIncidence_cos);

HWY_INLINE Lane All(float value) { return hn::Set(kTag, value); }

struct Vectors {
  Lane x, y, z;
};

HWY_INLINE Lane Dot(const Vectors& a, const Vectors& b) {
  return a.x * b.x + (a.y * b.y + a.z * b.z);
}

// A symmetric matrix, or the sums of products of coordinates.
struct Symmetric {
  Lane xx, xy, xz, yy, yz, zz;
};

HWY_INLINE Vectors Times(const Symmetric& m, const Vectors& v) {
  return {m.xx * v.x + (m.xy * v.y + m.xz * v.z), m.xy * v.x + (m.yy * v.y + m.yz * v.z),
          m.xz * v.x + (m.yz * v.y + m.zz * v.z)};
}

// det(C) C^-1; defined also where C is singular.
HWY_INLINE Symmetric Adjugate(const Symmetric& c) {
  return {c.yy * c.zz - c.yz * c.yz, c.yz * c.xz - c.zz * c.xy, c.xy * c.yz - c.xz * c.yy,
          c.zz * c.xx - c.xz * c.xz, c.xz * c.xy - c.xx * c.yz, c.xx * c.yy - c.xy * c.xy};
}

// Sums over the neighbours of each pixel, about the pixel's own point.
struct WindowSums {
  Vectors sum;
  Symmetric products;
  Lane count;
};

// Whole numbers.
struct Windows {
  Lane radius_px, step_px;
};

HWY_INLINE Windows WindowsOf(Lane radius_m, Lane pixel_m, float max_step_px) {
  // Without a point the share is NaN, which hn::Max drops.
  const Lane px = hn::Min(hn::Max(radius_m / pixel_m, All(kMinWindow_px)), All(kMaxWindow_px));
  // px / kSamplesAcrossRadius, rounded.
  const Lane rounded =
      hn::Trunc((All(2) * px + All(kSamplesAcrossRadius)) / All(2 * kSamplesAcrossRadius));
  const Lane step_px = hn::Min(hn::Max(rounded, All(1)), All(max_step_px));
  const Lane steps = hn::Trunc(hn::Trunc(px) / step_px);
  return {hn::Max(step_px, steps * step_px), step_px};
}

// The sums of one window, the same for all lanes, around the pixels from `column` on.
HWY_INLINE void AddWindow(const PointPlanes& points, int row, int column, int radius_px,
                          int step_px, const Vectors& p, Lane reach_m2, LaneMask wanted,
                          WindowSums& sums) {
  const int top = std::max(row - radius_px, row % step_px);
  const int bottom = std::min(row + radius_px, points.height - 1);
  for (int v = top; v <= bottom; v += step_px) {
    const float *xs = points.x.Row(v) + column, *ys = points.y.Row(v) + column,
                *zs = points.z.Row(v) + column;
    for (int u = -radius_px; u <= radius_px; u += step_px) {
      Vectors q{hn::LoadU(kTag, xs + u) - p.x, hn::LoadU(kTag, ys + u) - p.y,
                hn::LoadU(kTag, zs + u) - p.z};
      const LaneMask counts = hn::And(hn::Le(Dot(q, q), reach_m2), wanted);
      q = {hn::IfThenElseZero(counts, q.x), hn::IfThenElseZero(counts, q.y),
           hn::IfThenElseZero(counts, q.z)};
      sums.sum = {sums.sum.x + q.x, sums.sum.y + q.y, sums.sum.z + q.z};
      Symmetric& s = sums.products;
      s = {s.xx + q.x * q.x, s.xy + q.x * q.y, s.xz + q.x * q.z,
           s.yy + q.y * q.y, s.yz + q.y * q.z, s.zz + q.z * q.z};
      sums.count = sums.count + hn::IfThenElseZero(counts, All(1));
    }
  }
}

// The unit normal n that minimises n^T C n for fixed n . ray (noise along the ray): n ~ C^-1 ray.
// Zero where the points lie on a line. As NormalOf of normals.cc with one iteration.
HWY_INLINE Vectors NormalsOf(const WindowSums& sums, const Vectors& ray) {
  const Lane n = sums.count;
  const Vectors m{sums.sum.x / n, sums.sum.y / n, sums.sum.z / n};
  const Symmetric& s = sums.products;
  Symmetric c{s.xx / n - m.x * m.x, s.xy / n - m.x * m.y, s.xz / n - m.x * m.z,
              s.yy / n - m.y * m.y, s.yz / n - m.y * m.z, s.zz / n - m.z * m.z};
  const Lane scale = c.xx + (c.yy + c.zz);
  c = {c.xx / scale, c.xy / scale, c.xz / scale, c.yy / scale, c.yz / scale, c.zz / scale};
  const Symmetric inverse = Adjugate(c);
  Vectors normal = Times(inverse, ray);
  const Lane norm = hn::Sqrt(Dot(normal, normal));
  normal = {normal.x / norm, normal.y / norm, normal.z / norm};
  // The two smaller eigenvalues of a line are noise of the arithmetic.
  const LaneMask is_spread = hn::Ge(inverse.xx + (inverse.yy + inverse.zz), All(1e-5f));
  const LaneMask is_known = hn::And(hn::And(hn::Ge(n, All(3)), hn::Gt(scale, hn::Zero(kTag))),
                                    hn::And(is_spread, hn::Gt(norm, All(1e-12f))));
  const LaneMask is_away = hn::Gt(Dot(normal, ray), hn::Zero(kTag));
  const Lane turn = hn::IfThenElse(is_away, All(-1), All(1));
  return {hn::IfThenElseZero(is_known, normal.x * turn),
          hn::IfThenElseZero(is_known, normal.y * turn),
          hn::IfThenElseZero(is_known, normal.z * turn)};
}

// NormalSigma_rad of normals.cc.
HWY_INLINE Lane SigmasOf(Lane sigma_m, Lane radius_m, Lane sample_count) {
  const Lane independent = hn::Max(sample_count, All(1));
  const Lane sigma_rad = All(2) * sigma_m / (radius_m * hn::Sqrt(independent));
  return hn::Min(sigma_rad, All(kUnknownSigma_rad));
}

// Two points of a surface that lie the radius apart differ by three deviations of either's noise
// besides; never farther than a radius that follows from noise alone.
HWY_INLINE Lane ReachesOf(Lane radius_m, Lane sigma_m) {
  const Lane apart_m = hn::Sqrt(radius_m * radius_m + All(9) * sigma_m * sigma_m);
  return hn::Min(All(kNormalRadius_sigma) * sigma_m, apart_m);
}

HWY_INLINE void EstimateBlock(const PointPlanes& points, int row, int column, RowNormals& normals) {
  const Vectors p{hn::LoadU(kTag, points.x.Row(row) + column),
                  hn::LoadU(kTag, points.y.Row(row) + column),
                  hn::LoadU(kTag, points.z.Row(row) + column)};
  const Lane sigma_m = hn::LoadU(kTag, points.sigma_m.Row(row) + column);
  const Lane range_m = hn::Sqrt(Dot(p, p));
  const Lane pixel_m = range_m * All(points.pixel_angle_rad);
  const Lane of_noise_m = NormalRadius_m(sigma_m, All(points.sample_px) * pixel_m);
  const Lane radius_m = hn::Max(of_noise_m, All(kMinWindow_px) * pixel_m);
  const Lane reach_m =
      All(std::numbers::sqrt2_v<float>) *
      hn::Max(ReachesOf(of_noise_m, sigma_m), All(kMaxSlant * kMinWindow_px) * pixel_m);
  const Windows windows =
      WindowsOf(radius_m, pixel_m, std::max(1.0f, std::floor(points.sample_px)));
  // Neighbours mostly have windows of one size: each size is summed once, for all who have it.
  LaneMask waiting = hn::Ge(range_m, hn::Zero(kTag));  // not where there is no point
  const Lane none = hn::Zero(kTag);
  WindowSums sums{{none, none, none}, {none, none, none, none, none, none}, none};
  Lane density = none;  // pixels that a sample stands for
  alignas(32) float radius_px[kMaxLanes], step_px[kMaxLanes];
  hn::Store(windows.radius_px, kTag, radius_px);
  hn::Store(windows.step_px, kTag, step_px);
  while (!hn::AllFalse(kTag, waiting)) {
    const std::size_t k = hn::FindKnownFirstTrue(kTag, waiting);
    const LaneMask same = hn::And(waiting, hn::And(hn::Eq(windows.radius_px, All(radius_px[k])),
                                                   hn::Eq(windows.step_px, All(step_px[k]))));
    AddWindow(points, row, column, static_cast<int>(radius_px[k]), static_cast<int>(step_px[k]), p,
              reach_m * reach_m, same, sums);
    density = density + hn::IfThenElseZero(same, All(step_px[k] * step_px[k]));
    waiting = hn::AndNot(same, waiting);
  }
  const Vectors ray{p.x / range_m, p.y / range_m, p.z / range_m};
  const Vectors normal = NormalsOf(sums, ray);
  const auto at = static_cast<std::size_t>(column);
  hn::StoreU(normal.x, kTag, &normals.x[at]);
  hn::StoreU(normal.y, kTag, &normals.y[at]);
  hn::StoreU(normal.z, kTag, &normals.z[at]);
  const Lane sample_count = sums.count * density / All(points.sample_px * points.sample_px);
  hn::StoreU(SigmasOf(sigma_m, radius_m, sample_count), kTag, &normals.sigma_rad[at]);
}

void EstimateBlocks(const PointPlanes& points, int row, RowNormals& normals) {
  for (int column = 0; column < points.width; column += static_cast<int>(hn::Lanes(kTag))) {
    EstimateBlock(points, row, column, normals);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace cwm::perception
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cwm::perception {

HWY_EXPORT(EstimateBlocks);

float NormalRadius_m(float sigma_m, float spacing_m) {
  namespace hn = hwy::HWY_NAMESPACE;
  constexpr hn::CappedTag<float, 1> kOne;
  return hn::GetLane(
      HWY_NAMESPACE::NormalRadius_m(hn::Set(kOne, sigma_m), hn::Set(kOne, spacing_m)));
}

RowNormals::RowNormals(int width) {
  const auto size = static_cast<std::size_t>(width) + kMaxLanes;
  for (std::vector<float>* values : {&x, &y, &z, &sigma_rad}) values->resize(size);
}

void EstimateRow(const PointPlanes& points, int row, RowNormals& normals) {
  HWY_DYNAMIC_DISPATCH(EstimateBlocks)(points, row, normals);
}

}  // namespace cwm::perception
#endif  // HWY_ONCE
