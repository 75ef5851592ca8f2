#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/kernels/solid_lanes.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include <algorithm>

#include "collision/geometry/solid_distance-inl.h"
#include "collision/kernels/kink.h"
#include "collision/kernels/solid_lanes.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::collision {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using cwm::HWY_NAMESPACE::Above;
using cwm::HWY_NAMESPACE::SquaredDistanceToSide_m2;
using Tag = hn::CappedTag<double, kSampleLanes>;
using Lane = hn::Vec<Tag>;
using LaneMask = hn::Mask<Tag>;
using Vectors = cwm::HWY_NAMESPACE::Triple<Lane>;
constexpr Tag kTag;

// Nearer to a sharp edge than this share of the solid's size, the direction away from it is lost in
// the rounding of poses and a face's normal is used instead (as in signed_distance.cc).
constexpr double kRoundoff = 1e-11;

HWY_INLINE Lane All(double value) { return hn::Set(kTag, value); }
HWY_INLINE Vectors AllOf(const double* v) { return {All(v[0]), All(v[1]), All(v[2])}; }

HWY_INLINE Vectors Scaled(const Vectors& v, Lane by) { return {v.x * by, v.y * by, v.z * by}; }

// An answer of SampleLanes.
struct Sampled {
  Lane distance_m;
  Vectors gradient;
  Lane gap_m;
};

HWY_INLINE Vectors IfThenElse(LaneMask mask, const Vectors& yes, const Vectors& no) {
  return {hn::IfThenElse(mask, yes.x, no.x), hn::IfThenElse(mask, yes.y, no.y),
          hn::IfThenElse(mask, yes.z, no.z)};
}

// Two alternatives at the faces of a convex solid count only where the solid is left or touched.
HWY_INLINE Lane GapOf(Lane highest, Lane second) {
  return hn::IfThenElse(hn::Le(highest, All(kKinkTolerance_m)), highest - second,
                        All(NearestLanes::kNone));
}

// Every form takes points as offsets from its origin.
struct RoundForm {
  explicit RoundForm(const LaneSolid& s)
      : axis(AllOf(s.axis[2])),
        across(AllOf(s.axis[0])),
        radius_m(All(s.size[0])),
        half_m(All(s.size[1])) {}
  Vectors axis, across;
  Lane radius_m, half_m;

  HWY_INLINE Vectors FromCore(const Vectors& p) const {
    const Lane along = hn::Max(hn::Min(Dot(axis, p), half_m), hn::Neg(half_m));
    return Minus(p, Scaled(axis, along));
  }
  HWY_INLINE Lane Distance_m(const Vectors& p) const {
    return DistanceToSphere_m(FromCore(p), radius_m);
  }
  HWY_INLINE Sampled Sample(const Vectors& p) const {
    const Vectors d = FromCore(p);
    const Lane length = hn::Sqrt(Dot(d, d));
    // On the core every direction across it is valid.
    const LaneMask off = hn::Gt(length, hn::Zero(kTag));
    return {DistanceToSphere_m(d, radius_m), IfThenElse(off, Scaled(d, All(1) / length), across),
            All(2) * length};
  }
};

struct BoxForm {
  explicit BoxForm(const LaneSolid& s)
      : axis{AllOf(s.axis[0]), AllOf(s.axis[1]), AllOf(s.axis[2])},
        half_m(AllOf(s.size)),
        roundoff_m(All(kRoundoff * std::max({s.size[0], s.size[1], s.size[2]}))) {}
  Vectors axis[3];
  Vectors half_m;
  Lane roundoff_m;

  HWY_INLINE Vectors InBox(const Vectors& p) const {
    return {Dot(axis[0], p), Dot(axis[1], p), Dot(axis[2], p)};
  }
  HWY_INLINE Lane Distance_m(const Vectors& p) const { return DistanceToBox_m(InBox(p), half_m); }
  HWY_INLINE Sampled Sample(const Vectors& p) const {
    const Vectors at = InBox(p), h = HeightsOverBox(at, half_m);
    const auto above = Above(h);
    const Lane highest = above.highest_m;
    const Lane middle = hn::Max(hn::Min(h.x, h.y), hn::Min(hn::Max(h.x, h.y), h.z));
    const Lane opposite = hn::Neg(hn::Min(
        hn::Min(hn::Abs(at.x) + half_m.x, hn::Abs(at.y) + half_m.y), hn::Abs(at.z) + half_m.z));
    const LaneMask away = hn::Gt(above.outside_m, roundoff_m);
    const LaneMask on_x = hn::Eq(h.x, highest), on_xy = hn::Or(on_x, hn::Eq(h.y, highest));
    const Lane one = All(1), none = hn::Zero(kTag);
    const Vectors face{hn::IfThenElse(on_x, one, none),
                       hn::IfThenElse(hn::AndNot(on_x, on_xy), one, none),
                       hn::IfThenElse(on_xy, none, one)};
    const Vectors size = IfThenElse(away, Scaled(above.outside, one / above.outside_m), face);
    const Lane x = hn::CopySign(size.x, at.x), y = hn::CopySign(size.y, at.y),
               z = hn::CopySign(size.z, at.z);
    const Vectors gradient{x * axis[0].x + y * axis[1].x + z * axis[2].x,
                           x * axis[0].y + y * axis[1].y + z * axis[2].y,
                           x * axis[0].z + y * axis[1].z + z * axis[2].z};
    return {above.Distance_m(), gradient, GapOf(highest, hn::Max(middle, opposite))};
  }
};

// In the half-plane that begins at a solid's axis and holds the point.
struct Radial {
  Vectors off_axis;
  Lane radial, along;
};

HWY_INLINE Radial ToRadial(const Vectors& axis, const Vectors& p) {
  const Lane along = Dot(axis, p);
  const Vectors d = Minus(p, Scaled(axis, along));
  return {d, hn::Sqrt(Dot(d, d)), along};
}

struct CylinderForm {
  explicit CylinderForm(const LaneSolid& s)
      : axis(AllOf(s.axis[2])),
        across(AllOf(s.axis[0])),
        radius_m(All(s.size[0])),
        half_m(All(s.size[1])),
        roundoff_m(All(kRoundoff * std::max(s.size[0], s.size[1]))) {}
  Vectors axis, across;
  Lane radius_m, half_m, roundoff_m;

  HWY_INLINE Lane Distance_m(const Vectors& p) const {
    const Radial at = ToRadial(axis, p);
    return Above(at.radial - radius_m, hn::Abs(at.along) - half_m).Distance_m();
  }
  HWY_INLINE Sampled Sample(const Vectors& p) const {
    const Radial at = ToRadial(axis, p);
    const Lane side = at.radial - radius_m, cap = hn::Abs(at.along) - half_m;
    const auto above = Above(side, cap);
    const Lane opposite = hn::Max(hn::Neg(at.radial) - radius_m, cap - All(2) * hn::Abs(at.along));
    const Lane second = hn::Max(hn::Min(side, cap), opposite);
    const LaneMask away = hn::Gt(above.outside_m, roundoff_m);
    const LaneMask on_side = hn::Eq(side, above.highest_m);
    const Lane one = All(1), none = hn::Zero(kTag), inverse = one / above.outside_m;
    const Lane n_side =
        hn::IfThenElse(away, above.outside.x * inverse, hn::IfThenElse(on_side, one, none));
    const Lane n_cap = hn::CopySign(
        hn::IfThenElse(away, above.outside.y * inverse, hn::IfThenElse(on_side, none, one)),
        at.along);
    // On the axis every radial direction is valid.
    const Vectors outward =
        IfThenElse(hn::Gt(at.radial, none), Scaled(at.off_axis, one / at.radial), across);
    const Vectors gradient{n_side * outward.x + n_cap * axis.x, n_side * outward.y + n_cap * axis.y,
                           n_side * outward.z + n_cap * axis.z};
    return {above.Distance_m(), gradient, GapOf(above.highest_m, second)};
  }
};

struct HalfSpaceForm {
  explicit HalfSpaceForm(const LaneSolid& s) : axis(AllOf(s.axis[2])) {}
  Vectors axis;

  HWY_INLINE Lane Distance_m(const Vectors& p) const { return Dot(axis, p); }
  HWY_INLINE Sampled Sample(const Vectors& p) const {
    return {Distance_m(p), axis, All(NearestLanes::kNone)};
  }
};

// Signed, by even and odd crossings of the level line.
HWY_INLINE Lane DistanceToProfile_m(std::span<const ProfileEdge> edges, Lane x, Lane y) {
  Lane squared_m2 = All(NearestLanes::kNone);
  LaneMask inside = hn::MaskFromVec(hn::Zero(kTag));
  for (const ProfileEdge& e : edges) {
    const Lane along_x = All(e.along_x), along_y = All(e.along_y), a_y = All(e.a_y);
    const Lane u = x - All(e.a_x), v = y - a_y;
    const Lane way = (u * along_x + v * along_y) * All(e.inverse_length_m2);
    squared_m2 = hn::Min(squared_m2, SquaredDistanceToSide_m2(u, v, along_x, along_y, way));
    const LaneMask level = hn::Xor(hn::Gt(a_y, y), hn::Gt(All(e.a_y + e.along_y), y));
    const LaneMask left = hn::Lt(u, v * All(e.slope));
    inside = hn::Xor(inside, hn::And(level, left));
  }
  const Lane distance_m = hn::Sqrt(squared_m2);
  return hn::IfThenElse(inside, hn::Neg(distance_m), distance_m);
}

std::span<const ProfileEdge> EdgesOf(const LaneSolid& s) {
  return {s.edges, static_cast<std::size_t>(s.edge_count)};
}

struct RevolvedForm {
  explicit RevolvedForm(const LaneSolid& s) : axis(AllOf(s.axis[2])), edges(EdgesOf(s)) {}
  Vectors axis;
  std::span<const ProfileEdge> edges;

  HWY_INLINE Lane Distance_m(const Vectors& p) const {
    const Radial at = ToRadial(axis, p);
    return DistanceToProfile_m(edges, at.radial, at.along);
  }
};

struct PlateForm {
  explicit PlateForm(const LaneSolid& s)
      : axis{AllOf(s.axis[0]), AllOf(s.axis[1]), AllOf(s.axis[2])},
        half_m(All(0.5 * s.size[0])),
        edges(EdgesOf(s)) {}
  Vectors axis[3];
  Lane half_m;
  std::span<const ProfileEdge> edges;

  HWY_INLINE Lane Distance_m(const Vectors& p) const {
    const Lane face = hn::Abs(Dot(axis[2], p) + half_m) - half_m;
    const Lane border = DistanceToProfile_m(edges, Dot(axis[0], p), Dot(axis[1], p));
    return Above(border, face).Distance_m();
  }
};

template <int kCount>
HWY_INLINE Vectors OffsetsAt(const LanePoints<kCount>& points, std::size_t i,
                             const Vectors& origin) {
  const Vectors p{hn::Load(kTag, points.x + i), hn::Load(kTag, points.y + i),
                  hn::Load(kTag, points.z + i)};
  return Minus(p, origin);
}

template <class Form>
void MeasureForm(const LaneSolid& solid, const BlockPoints& points, BlockDistances& out) {
  const Form form(solid);
  const Vectors origin = AllOf(solid.origin);
  for (std::size_t i = 0; i < kBlockLanes; i += hn::Lanes(kTag)) {
    hn::Store(form.Distance_m(OffsetsAt(points, i, origin)), kTag, out.lane + i);
  }
}

void Measure(const LaneSolid& solid, const BlockPoints& points, BlockDistances& out) {
  switch (solid.form) {
    case LaneSolid::Form::kRound:
      return MeasureForm<RoundForm>(solid, points, out);
    case LaneSolid::Form::kBox:
      return MeasureForm<BoxForm>(solid, points, out);
    case LaneSolid::Form::kCylinder:
      return MeasureForm<CylinderForm>(solid, points, out);
    case LaneSolid::Form::kHalfSpace:
      return MeasureForm<HalfSpaceForm>(solid, points, out);
    case LaneSolid::Form::kRevolved:
      return MeasureForm<RevolvedForm>(solid, points, out);
    case LaneSolid::Form::kPlate:
      return MeasureForm<PlateForm>(solid, points, out);
  }
}

template <class Form>
void SampleForm(const LaneSolid& solid, const LanePoints<kSampleLanes>& points, LaneSamples& out) {
  const Form form(solid);
  const Vectors origin = AllOf(solid.origin);
  for (std::size_t i = 0; i < kSampleLanes; i += hn::Lanes(kTag)) {
    const Sampled sampled = form.Sample(OffsetsAt(points, i, origin));
    hn::Store(sampled.distance_m, kTag, out.distance_m + i);
    hn::Store(sampled.gradient.x, kTag, out.gradient_x + i);
    hn::Store(sampled.gradient.y, kTag, out.gradient_y + i);
    hn::Store(sampled.gradient.z, kTag, out.gradient_z + i);
    hn::Store(sampled.gap_m, kTag, out.gap_m + i);
  }
}

void Sample(const LaneSolid& solid, const LanePoints<kSampleLanes>& points, LaneSamples& out) {
  switch (solid.form) {
    case LaneSolid::Form::kRound:
      return SampleForm<RoundForm>(solid, points, out);
    case LaneSolid::Form::kBox:
      return SampleForm<BoxForm>(solid, points, out);
    case LaneSolid::Form::kCylinder:
      return SampleForm<CylinderForm>(solid, points, out);
    case LaneSolid::Form::kHalfSpace:
      return SampleForm<HalfSpaceForm>(solid, points, out);
    case LaneSolid::Form::kRevolved:
    case LaneSolid::Form::kPlate:
      break;
  }
}

double Keep(const BlockDistances& d, const CandidateRef& ref, double limit_m,
            NearestLanes& nearest) {
  constexpr hn::RebindToSigned<Tag> kWhole;
  const auto met_order = hn::Set(kWhole, ref.order), candidate = hn::Set(kWhole, ref.candidate);
  const Lane limit = All(limit_m);
  Lane farthest = hn::Zero(kTag);
  for (std::size_t i = 0; i < kBlockLanes; i += hn::Lanes(kTag)) {
    const Lane now = hn::Load(kTag, d.lane + i), before = hn::Load(kTag, nearest.best_m + i);
    const auto order = hn::Load(kWhole, nearest.order + i);
    const LaneMask is_earlier = hn::RebindMask(kTag, hn::Lt(met_order, order));
    const LaneMask is_nearer =
        hn::Or(hn::Lt(now, before), hn::And(hn::Eq(now, before), is_earlier));
    const auto is_taken = hn::RebindMask(kWhole, is_nearer);
    const Lane best = hn::IfThenElse(is_nearer, now, before);
    const Lane other = hn::IfThenElse(is_nearer, before, now);
    const auto kept = hn::Load(kWhole, nearest.candidate + i);
    hn::Store(hn::IfThenElse(is_taken, met_order, order), kWhole, nearest.order + i);
    hn::Store(hn::IfThenElse(is_taken, candidate, kept), kWhole, nearest.candidate + i);
    hn::Store(hn::Min(hn::Load(kTag, nearest.second_m + i), other), kTag, nearest.second_m + i);
    hn::Store(best, kTag, nearest.best_m + i);
    const Lane reach = hn::Max(hn::Min(best, limit), hn::Neg(best));
    hn::Store(reach, kTag, nearest.reach_m.lane + i);
    farthest = hn::Max(farthest, reach);
  }
  return hn::GetLane(hn::MaxOfLanes(kTag, farthest));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace cwm::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cwm::collision {

HWY_EXPORT(Measure);
HWY_EXPORT(Sample);
HWY_EXPORT(Keep);

void NearestLanes::Clear(double limit_m) {
  for (int i = 0; i < kBlockLanes; ++i) {
    best_m[i] = second_m[i] = kNone;
    reach_m.lane[i] = limit_m;
    order[i] = std::numeric_limits<std::int64_t>::max();
    candidate[i] = -1;
  }
}

void ComputeDistances(const LaneSolid& solid, const BlockPoints& points,
                      BlockDistances& distances_m) {
  HWY_DYNAMIC_DISPATCH(Measure)(solid, points, distances_m);
}

double UpdateNearest(const BlockDistances& distances_m, const CandidateRef& ref, double limit_m,
                     NearestLanes& nearest) {
  return HWY_DYNAMIC_DISPATCH(Keep)(distances_m, ref, limit_m, nearest);
}

void SampleLanes(const LaneSolid& solid, const LanePoints<kSampleLanes>& points,
                 LaneSamples& samples) {
  HWY_DYNAMIC_DISPATCH(Sample)(solid, points, samples);
}

}  // namespace cwm::collision
#endif  // HWY_ONCE
