#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "perception/segmentation/surface_planes.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include <algorithm>
#include <cmath>

#include "hwy/highway.h"
#include "perception/cloud/normal_radius-inl.h"
#include "perception/cloud/tolerances.h"
#include "perception/segmentation/surface_graph.h"
#include "perception/segmentation/surface_planes.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::perception {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, kMaxLanes>;
using Lane = hn::Vec<Tag>;
using LaneMask = hn::Mask<Tag>;
constexpr Tag kTag;
constexpr hn::Rebind<std::int32_t, Tag> kWhole;
using WholeLane = hn::Vec<decltype(kWhole)>;

// derived: the tolerance of a pixel's distance from its neighbour's tangent plane, in pixels. On
// one surface 4 pairs of 1000 exceed kNoiseReach_sigma, by the noise of the points and of the
// normal. Across the edge of a box, seen at 45 degrees, the distance is that of the pixels,
// whatever the noise: lower steps between two surfaces cannot be distinguished from edges of one.
constexpr float kStep_px = 1.5f;

HWY_INLINE Lane All(float value) { return hn::Set(kTag, value); }

// The bits where the mask says yes, else 0.
HWY_INLINE WholeLane BitsWhere(LaneMask mask, int bits) {
  return hn::IfThenElseZero(hn::RebindMask(kWhole, mask), hn::Set(kWhole, bits));
}

HWY_INLINE void StoreBytes(WholeLane values, std::uint8_t* to) {
  constexpr hn::Rebind<std::uint8_t, Tag> kBytes;
  hn::StoreU(hn::DemoteTo(kBytes, values), kBytes, to);
}

HWY_INLINE void StoreBytes(LaneMask mask, std::uint8_t* to) {
  StoreBytes(BitsWhere(mask, 0xff), to);
}

HWY_INLINE Lane MaxJumps_m(Lane sigma_m) { return All(3) * sigma_m + All(0.01f); }

struct Vectors {
  Lane x, y, z;
};

HWY_INLINE Lane Load(const ImagePlane& plane, int row, int column) {
  return hn::LoadU(kTag, plane.Row(row) + column);
}

HWY_INLINE Vectors PointAt(const SurfacePlanes& planes, int row, int column) {
  return {Load(planes.x, row, column), Load(planes.y, row, column), Load(planes.z, row, column)};
}

HWY_INLINE Vectors NormalAt(const SurfacePlanes& planes, int row, int column) {
  return {Load(planes.normal_x, row, column), Load(planes.normal_y, row, column),
          Load(planes.normal_z, row, column)};
}

HWY_INLINE Vectors Minus(const Vectors& a, const Vectors& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

HWY_INLINE Lane Dot(const Vectors& a, const Vectors& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

HWY_INLINE LaneMask IsFrontal(const Vectors& normal, const Vectors& point, Lane range_m) {
  return hn::Ge(hn::Abs(Dot(normal, point)), All(kSteepIncidence_cos) * range_m);
}

// Linked where the ranges differ as on one surface, and where each of the two lies on the other's
// tangent plane, as far as it is known; one of them is enough where one is seen at a grazing angle,
// as behind the edge of a box. Slanted surfaces may differ by three times as much in range when
// each lies on the other's tangent plane.
HWY_INLINE void LinkBlock(const SurfacePlanes& planes, int row, int column, RowLinks& links) {
  const Lane range_m = Load(planes.range_m, row, column);
  const Lane sigma_m = Load(planes.sigma_m, row, column);
  const Lane min_step_m = All(kStep_px * planes.pixel_angle_rad) * range_m;
  const Vectors here = PointAt(planes, row, column), normal_here = NormalAt(planes, row, column);
  const LaneMask frontal_here = IsFrontal(normal_here, here, range_m);
  WholeLane linked = hn::Zero(kWhole), steps = hn::Zero(kWhole);
  for (int k = 0; k < 8; ++k) {
    const int v = row + kNeighbourOffsets[k][0], u = column + kNeighbourOffsets[k][1];
    if (v < 0 || v >= planes.height) continue;
    const Vectors there = PointAt(planes, v, u);
    const Vectors d = Minus(there, here);
    const Lane range_there_m = Load(planes.range_m, v, u);
    const Lane jump_m = hn::Abs(range_m - range_there_m);
    const Lane max_sigma_m = hn::Max(Load(planes.sigma_m, v, u), sigma_m);
    const Lane max_m = MaxJumps_m(max_sigma_m);
    const Lane step_m = hn::Max(All(kNoiseReach_sigma) * max_sigma_m, min_step_m);
    const Vectors normal_there = NormalAt(planes, v, u);
    const Lane off_here_m = hn::Abs(Dot(normal_here, d));
    const Lane off_there_m = hn::Abs(Dot(normal_there, d));
    const LaneMask frontal = hn::And(frontal_here, IsFrontal(normal_there, there, range_there_m));
    // Comparisons with an unknown normal, NaN, are false.
    const LaneMask on = hn::And(hn::Le(off_here_m, step_m), hn::Le(off_there_m, step_m));
    const LaneMask off_one = hn::Or(hn::Gt(off_here_m, step_m), hn::Gt(off_there_m, step_m));
    const LaneMask off_both = hn::And(hn::Gt(off_here_m, step_m), hn::Gt(off_there_m, step_m));
    const LaneMask off = hn::Or(hn::And(frontal, off_one), off_both);
    const LaneMask is_near = hn::Le(jump_m, max_m);
    const LaneMask is_linked =
        hn::Or(hn::AndNot(off, is_near), hn::And(hn::Le(jump_m, All(3) * max_m), on));
    linked = hn::Or(linked, BitsWhere(is_linked, 1 << k));
    steps = hn::Or(steps, BitsWhere(hn::AndNot(is_linked, is_near), 0xff));
  }
  StoreBytes(linked, &links.linked[static_cast<std::size_t>(column)]);
  StoreBytes(steps, &links.steps[static_cast<std::size_t>(column)]);
}

struct Place {
  int row, column;
};

// Yes where the surface turns towards the viewer from a to b by more than the angle. With the
// angles A and B of the normals to the plane across the line from a to b, A - B > t means sin(A -
// B) > 0 and cos(A - B) < cos t.
HWY_INLINE LaneMask TurnsInwards(const SurfacePlanes& planes, const Place& a, const Place& b,
                                 float cos_angle) {
  const Vectors d = Minus(PointAt(planes, b.row, b.column), PointAt(planes, a.row, a.column));
  const Lane length2 = Dot(d, d);
  // Sines and cosines times the length.
  const Lane sin_a = Dot(NormalAt(planes, a.row, a.column), d);
  const Lane sin_b = Dot(NormalAt(planes, b.row, b.column), d);
  const auto cosine = [&](Lane sine) HWY_ATTR {
    const Lane squared = length2 - sine * sine;
    return hn::Sqrt(hn::Max(squared, hn::Zero(kTag)));
  };
  const Lane cos_a = cosine(sin_a), cos_b = cosine(sin_b);
  return hn::And(hn::Gt(sin_a * cos_b - cos_a * sin_b, hn::Zero(kTag)),
                 hn::Lt(cos_a * cos_b + sin_a * sin_b, length2 * All(cos_angle)));
}

// One reach, the same for all lanes, around the pixels from `at` on.
HWY_INLINE LaneMask CreasesAround(const SurfacePlanes& planes, const Place& at, int reach_px,
                                  float cos_angle) {
  constexpr int kDirections[4][2] = {{0, 1}, {1, 0}, {1, 1}, {1, -1}};
  const Lane range_m = Load(planes.range_m, at.row, at.column);
  const Lane slack_m = MaxJumps_m(Load(planes.sigma_m, at.row, at.column));
  LaneMask crease = hn::MaskFromVec(hn::Zero(kTag));
  for (const auto& d : kDirections) {
    const int steps = d[0] != 0 && d[1] != 0 ? (reach_px * 7 + 5) / 10 : reach_px;  // 1 / sqrt(2)
    const Place a{at.row - steps * d[0], at.column - steps * d[1]};
    const Place b{at.row + steps * d[0], at.column + steps * d[1]};
    if (a.row < 0 || b.row >= planes.height) continue;
    const Lane range_a = Load(planes.range_m, a.row, a.column);
    const Lane range_b = Load(planes.range_m, b.row, b.column);
    // A slanted surface changes in range over the reach, evenly on both sides; a jump does not.
    const LaneMask even = hn::And(hn::Le(hn::Abs(range_a + range_b - All(2) * range_m), slack_m),
                                  hn::Le(hn::Abs(range_a - range_b), All(4) * slack_m));
    crease = hn::Or(crease, hn::And(even, TurnsInwards(planes, a, b, cos_angle)));
  }
  return crease;
}

// Whole numbers.
HWY_INLINE Lane ReachesOf(const SurfacePlanes& planes, const Place& at) {
  const Lane range_m = Load(planes.range_m, at.row, at.column);
  const Lane radius_m = NormalRadius_m(Load(planes.sigma_m, at.row, at.column),
                                       All(planes.sample_angle_rad) * range_m);
  const Lane pixel_m = hn::Max(All(1e-6f), range_m * All(planes.pixel_angle_rad));
  // Without a point the share is NaN, which hn::Max drops.
  const Lane px = hn::Max(radius_m / pixel_m, All(kMinWindow_px));
  return hn::Trunc(hn::Min(px, All(kMaxWindow_px)));
}

HWY_INLINE void CreaseBlock(const SurfacePlanes& planes, const Place& at, float cos_angle,
                            std::uint8_t* crease) {
  const Lane range_m = Load(planes.range_m, at.row, at.column);
  const Lane reaches = ReachesOf(planes, at);
  alignas(32) float reach_px[kMaxLanes];
  hn::Store(reaches, kTag, reach_px);
  // Neighbours mostly have the same reach: each is looked at once, for all who have it.
  LaneMask waiting = hn::Ge(range_m, hn::Zero(kTag));  // not where there is no point
  LaneMask creases = hn::MaskFromVec(hn::Zero(kTag));
  while (!hn::AllFalse(kTag, waiting)) {
    const float reach = reach_px[hn::FindKnownFirstTrue(kTag, waiting)];
    const LaneMask same = hn::And(waiting, hn::Eq(reaches, All(reach)));
    const LaneMask around = CreasesAround(planes, at, static_cast<int>(reach), cos_angle);
    creases = hn::Or(creases, hn::And(same, around));
    waiting = hn::AndNot(same, waiting);
  }
  StoreBytes(creases, crease);
}

void LinkBlocks(const SurfacePlanes& planes, int row, RowLinks& links) {
  for (int column = 0; column < planes.width; column += static_cast<int>(hn::Lanes(kTag))) {
    LinkBlock(planes, row, column, links);
  }
}

void CreaseBlocks(const SurfacePlanes& planes, int row, float cos_angle, std::uint8_t* crease) {
  for (int column = 0; column < planes.width; column += static_cast<int>(hn::Lanes(kTag))) {
    CreaseBlock(planes, {row, column}, cos_angle, crease + column);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace cwm::perception
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cwm::perception {

HWY_EXPORT(LinkBlocks);
HWY_EXPORT(CreaseBlocks);

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
    : linked(static_cast<std::size_t>(width + kMaxLanes)),
      steps(static_cast<std::size_t>(width + kMaxLanes)) {}

void LinkRow(const SurfacePlanes& planes, int row, RowLinks& links) {
  HWY_DYNAMIC_DISPATCH(LinkBlocks)(planes, row, links);
}

void CreaseRow(const SurfacePlanes& planes, int row, float angle_rad,
               std::vector<std::uint8_t>& crease) {
  crease.resize(static_cast<std::size_t>(planes.width) + kMaxLanes);
  HWY_DYNAMIC_DISPATCH(CreaseBlocks)(planes, row, std::cos(angle_rad), crease.data());
}

}  // namespace cwm::perception
#endif  // HWY_ONCE
