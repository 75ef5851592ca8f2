#include "perception/segmentation/surface_planes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "perception/cloud/lanes.h"
#include "perception/cloud/normals.h"
#include "perception/cloud/tolerances.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {
namespace {

// derived: the tolerance of a pixel's distance from its neighbour's tangent plane, in pixels. On
// one surface 4 pairs of 1000 exceed kNoiseReach_sigma, by the noise of the points and of the
// normal. Across the edge of a box, seen at 45 degrees, the distance is that of the pixels,
// whatever the noise: lower steps between two surfaces cannot be distinguished from edges of one.
constexpr float kStep_px = 1.5f;

using Bytes = std::uint8_t __attribute__((vector_size(kLanes)));

CWM_LANES_INLINE void StoreBytes(const LaneMask& lanes, std::uint8_t* to) {
  const Bytes bytes = __builtin_convertvector(lanes, Bytes);
  std::memcpy(to, &bytes, sizeof(bytes));
}

CWM_LANES_INLINE Lanes LargestJumps_m(const Lanes& sigma_m) { return 3.0f * sigma_m + 0.01f; }

struct Vectors {
  Lanes x, y, z;
};

CWM_LANES_INLINE Vectors Load(const ImagePlane& x, const ImagePlane& y, const ImagePlane& z,
                              int row, int column) {
  return {LoadLanes(x.Row(row) + column), LoadLanes(y.Row(row) + column),
          LoadLanes(z.Row(row) + column)};
}

CWM_LANES_INLINE Lanes Dot(const Vectors& a, const Vectors& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

CWM_LANES_INLINE LaneMask IsFrontal(const Vectors& normal, const Vectors& point,
                                    const Lanes& range_m) {
  return Absolute(Dot(normal, point)) >= float{kSteepIncidence_cos} * range_m;
}

// Links pixels whose ranges differ as on one surface and that lie on each other's tangent planes,
// where these are known; one of the two suffices if one is seen at a grazing angle, as behind the
// edge of a box. On slanted surfaces the ranges may differ by three times as much if each lies on
// the other's tangent plane.
CWM_LANES_INLINE void LinkBlock(const SurfacePlanes& planes, int row, int column, RowLinks& links) {
  const auto point = [&](int v, int u) { return Load(planes.x, planes.y, planes.z, v, u); };
  const auto normal = [&](int v, int u) {
    return Load(planes.normal_x, planes.normal_y, planes.normal_z, v, u);
  };
  const Lanes range_m = LoadLanes(planes.range_m.Row(row) + column);
  const Lanes sigma_m = LoadLanes(planes.sigma_m.Row(row) + column);
  const Lanes least_step_m = kStep_px * planes.pixel_angle_rad * range_m;
  const Vectors here = point(row, column), normal_here = normal(row, column);
  const LaneMask frontal_here = IsFrontal(normal_here, here, range_m);
  LaneMask linked{}, steps{};
  for (int k = 0; k < 8; ++k) {
    const int v = row + kBeside[k][0], u = column + kBeside[k][1];
    if (v < 0 || v >= planes.height) continue;
    const Vectors there = point(v, u);
    const Vectors d{there.x - here.x, there.y - here.y, there.z - here.z};
    const Lanes range_there_m = LoadLanes(planes.range_m.Row(v) + u);
    const Lanes jump_m = Absolute(range_m - range_there_m);
    const Lanes other_m = LoadLanes(planes.sigma_m.Row(v) + u);
    const Lanes most_sigma_m = Greater(other_m, sigma_m);
    const Lanes most_m = LargestJumps_m(most_sigma_m);
    const Lanes step_m = Greater(float{kNoiseReach_sigma} * most_sigma_m, least_step_m);
    const Vectors normal_there = normal(v, u);
    const Lanes off_here_m = Absolute(Dot(normal_here, d));
    const Lanes off_there_m = Absolute(Dot(normal_there, d));
    const LaneMask frontal = frontal_here & IsFrontal(normal_there, there, range_there_m);
    // Comparisons with an unknown normal (NaN) are false.
    const LaneMask on = (off_here_m <= step_m) & (off_there_m <= step_m);
    const LaneMask off_one = (off_here_m > step_m) | (off_there_m > step_m);
    const LaneMask off_both = (off_here_m > step_m) & (off_there_m > step_m);
    const LaneMask off = (frontal & off_one) | off_both;
    const LaneMask is_linked = ((jump_m <= most_m) & ~off) | ((jump_m <= 3.0f * most_m) & on);
    linked |= is_linked & (1 << k);
    steps |= (jump_m <= most_m) & ~is_linked;
  }
  StoreBytes(linked, &links.linked[static_cast<std::size_t>(column)]);
  StoreBytes(steps, &links.steps[static_cast<std::size_t>(column)]);
}

struct Place {
  int row, column;
};

// True if the surface turns towards the viewer from a to b by more than the angle t. With the
// angles A and B of the normals to the plane across the line from a to b, A - B > t means sin(A -
// B) > 0 and cos(A - B) < cos t.
CWM_LANES_INLINE LaneMask TurnsInwards(const SurfacePlanes& planes, const Place& a, const Place& b,
                                       float cos_angle) {
  const Vectors from = Load(planes.x, planes.y, planes.z, a.row, a.column);
  const Vectors to = Load(planes.x, planes.y, planes.z, b.row, b.column);
  const Vectors d{to.x - from.x, to.y - from.y, to.z - from.z};
  const Lanes length2 = Dot(d, d);
  const auto normal = [&](const Place& p) {
    return Load(planes.normal_x, planes.normal_y, planes.normal_z, p.row, p.column);
  };
  // Sines and cosines times the length.
  const Lanes sin_a = Dot(normal(a), d), sin_b = Dot(normal(b), d);
  const auto cosine = [&](const Lanes& sine) {
    const Lanes squared = length2 - sine * sine;
    return SquareRoots(Where(squared > 0.0f, squared));
  };
  const Lanes cos_a = cosine(sin_a), cos_b = cosine(sin_b);
  return (sin_a * cos_b - cos_a * sin_b > 0.0f) &
         (cos_a * cos_b + sin_a * sin_b < length2 * cos_angle);
}

// Creases at the pixels from `at` on, for one reach, the same for all SIMD lanes.
CWM_LANES_INLINE LaneMask CreasesAround(const SurfacePlanes& planes, const Place& at, int reach_px,
                                        float cos_angle) {
  constexpr int kDirections[4][2] = {{0, 1}, {1, 0}, {1, 1}, {1, -1}};
  const Lanes range_m = LoadLanes(planes.range_m.Row(at.row) + at.column);
  const Lanes slack_m = LargestJumps_m(LoadLanes(planes.sigma_m.Row(at.row) + at.column));
  LaneMask crease{};
  for (const auto& d : kDirections) {
    const int steps = d[0] != 0 && d[1] != 0 ? (reach_px * 7 + 5) / 10 : reach_px;  // 1 / sqrt(2)
    const Place a{at.row - steps * d[0], at.column - steps * d[1]};
    const Place b{at.row + steps * d[0], at.column + steps * d[1]};
    if (a.row < 0 || b.row >= planes.height) continue;
    const Lanes range_a = LoadLanes(planes.range_m.Row(a.row) + a.column);
    const Lanes range_b = LoadLanes(planes.range_m.Row(b.row) + b.column);
    // On a slanted surface the range changes evenly on both sides; at a jump it does not.
    const LaneMask even = (Absolute(range_a + range_b - 2.0f * range_m) <= slack_m) &
                          (Absolute(range_a - range_b) <= 4.0f * slack_m);
    crease |= even & TurnsInwards(planes, a, b, cos_angle);
  }
  return crease;
}

CWM_LANES_INLINE LaneMask ReachesOf(const SurfacePlanes& planes, const Place& at) {
  LaneMask reach_px{};
  const Lanes range_m = LoadLanes(planes.range_m.Row(at.row) + at.column);
  const Lanes radius_m = NormalRadii_m(LoadLanes(planes.sigma_m.Row(at.row) + at.column),
                                       planes.sample_angle_rad * range_m);
  for (int k = 0; k < kLanes; ++k) {
    const float px = radius_m[k] / std::max(range_m[k] * planes.pixel_angle_rad, 1e-6f);
    // Without a point px is NaN, which this order of std::max drops.
    reach_px[k] = static_cast<int>(std::min(std::max(kMinWindow_px, px), kMaxWindow_px));
  }
  return reach_px;
}

CWM_LANES_INLINE void CreaseBlock(const SurfacePlanes& planes, const Place& at, float cos_angle,
                                  std::uint8_t* crease) {
  const Lanes range_m = LoadLanes(planes.range_m.Row(at.row) + at.column);
  const LaneMask reach_px = ReachesOf(planes, at);
  // Neighbours mostly have the same reach: each reach is evaluated once, for all lanes that have
  // it.
  LaneMask waiting = range_m >= Lanes{}, creases{};  // false without a point
  for (int k = 0; k < kLanes; ++k) {
    if (!waiting[k]) continue;
    const LaneMask same = waiting & (reach_px == reach_px[k]);
    creases |= same & CreasesAround(planes, at, reach_px[k], cos_angle);
    waiting &= ~same;
  }
  StoreBytes(creases, crease);
}

CWM_LANES_INLINE void LinkBlocks(const SurfacePlanes& planes, int row, RowLinks& links) {
  for (int column = 0; column < planes.width; column += kLanes) {
    LinkBlock(planes, row, column, links);
  }
}

CWM_LANES_INLINE void CreaseBlocks(const SurfacePlanes& planes, int row, float cos_angle,
                                   std::vector<std::uint8_t>& crease) {
  for (int column = 0; column < planes.width; column += kLanes) {
    CreaseBlock(planes, {row, column}, cos_angle, &crease[static_cast<std::size_t>(column)]);
  }
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void LinkWide(const SurfacePlanes& planes, int row,
                                              RowLinks& links) {
  LinkBlocks(planes, row, links);
}

__attribute__((target("avx2"))) void CreaseWide(const SurfacePlanes& planes, int row,
                                                float cos_angle,
                                                std::vector<std::uint8_t>& crease) {
  CreaseBlocks(planes, row, cos_angle, crease);
}
#endif

}  // namespace

SurfacePlanes PlanesOfSurface(const MeasuredPoints& measured, const std::vector<float>& range_m,
                              const Work& work) {
  const ImagePlane empty(measured.width, measured.height);
  SurfacePlanes planes{measured.width,
                       measured.height,
                       measured.pixel_angle_rad,
                       measured.sample_angle_rad(),
                       empty,
                       empty,
                       empty,
                       empty,
                       empty,
                       empty,
                       empty,
                       empty};
  const OrientedPoints& points = measured.oriented;
  ForEachPixel(measured, work, [&](std::size_t i, int row, int column) {
    planes.x.Row(row)[column] = points.points[i].x();
    planes.y.Row(row)[column] = points.points[i].y();
    planes.z.Row(row)[column] = points.points[i].z();
    planes.range_m.Row(row)[column] = range_m[i];
    planes.sigma_m.Row(row)[column] = points.sigma_m[i];
    if (points.normals[i].isZero()) return;
    planes.normal_x.Row(row)[column] = points.normals[i].x();
    planes.normal_y.Row(row)[column] = points.normals[i].y();
    planes.normal_z.Row(row)[column] = points.normals[i].z();
  });
  return planes;
}

RowLinks::RowLinks(int width)
    : linked(static_cast<std::size_t>(width + kLanes)),
      steps(static_cast<std::size_t>(width + kLanes)) {}

void LinkRow(const SurfacePlanes& planes, int row, RowLinks& links) {
#if defined(__x86_64__)
  if (HasWideLanes()) return LinkWide(planes, row, links);
#endif
  LinkBlocks(planes, row, links);
}

void CreaseRow(const SurfacePlanes& planes, int row, float angle_rad,
               std::vector<std::uint8_t>& crease) {
  crease.resize(static_cast<std::size_t>(planes.width) + kLanes);
  const float cos_angle = std::cos(angle_rad);
#if defined(__x86_64__)
  if (HasWideLanes()) return CreaseWide(planes, row, cos_angle, crease);
#endif
  CreaseBlocks(planes, row, cos_angle, crease);
}

}  // namespace cwm::perception
