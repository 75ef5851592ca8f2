#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "perception/search/point_lanes.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include <bit>
#include <cmath>
#include <variant>

#include "collision/geometry/lane_math-inl.h"
#include "hwy/highway.h"
#include "perception/search/point_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::perception {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using cwm::HWY_NAMESPACE::AllOf;
using Tag = hn::CappedTag<double, PointLanes::kMaxLanes>;
using Lane = hn::Vec<Tag>;
using LaneMask = hn::Mask<Tag>;
using Vectors = cwm::HWY_NAMESPACE::Triple<Lane>;
constexpr Tag kTag;

HWY_INLINE Lane All(double value) { return hn::Set(kTag, value); }

// Bit k: the k-th lane.
HWY_INLINE unsigned Bits(LaneMask mask) {
  std::uint8_t some[8] = {};
  hn::StoreMaskBits(kTag, mask, some);
  return some[0];
}

// The models below give each model's Distance_m and the cosine between its Normal, turned by its
// FacingSign, and the measured one, operation by operation.
struct PlaneLanes {
  explicit PlaneLanes(const PlaneModel& plane)
      : normal(AllOf<Lane>(plane.normal)), point(AllOf<Lane>(plane.point)) {}
  Vectors normal, point;

  HWY_INLINE Lane Distance_m(const Vectors& p) const { return Dot(normal, Minus(p, point)); }
  HWY_INLINE Lane Cosine(const Vectors&, const Vectors& n) const { return Dot(normal, n); }
};

struct SphereLanes {
  explicit SphereLanes(const SphereModel& sphere)
      : center(AllOf<Lane>(sphere.center)),
        radius_m(All(sphere.radius_m)),
        facing_sign(All(sphere.FacingSign())) {}
  Vectors center;
  Lane radius_m, facing_sign;

  HWY_INLINE Lane Distance_m(const Vectors& p) const {
    const Vectors q = Minus(p, center);
    return hn::Sqrt(Dot(q, q)) - radius_m;
  }
  HWY_INLINE Lane Cosine(const Vectors& p, const Vectors& n) const {
    const Vectors q = Minus(p, center);
    const Lane norm = hn::Sqrt(Dot(q, q));
    const LaneMask away = hn::Gt(norm, hn::Zero(kTag));
    const Vectors outward{hn::IfThenElseZero(away, q.x / norm),
                          hn::IfThenElseZero(away, q.y / norm),
                          hn::IfThenElse(away, q.z / norm, All(1))};
    return facing_sign * Dot(outward, n);
  }
};

// A cylinder is a cone of slope 0: its distance and its normal come out the same.
struct ConeLanes {
  explicit ConeLanes(const ConeModel& cone)
      : point(AllOf<Lane>(cone.point)),
        axis(AllOf<Lane>(cone.axis)),
        tilt(AllOf<Lane>(cone.slope * cone.axis)),
        on_axis(AllOf<Lane>(BasisFromZ(cone.axis).col(0))),
        radius_m(All(cone.radius_m)),
        slope(All(cone.slope)),
        length(All(std::sqrt(1 + cone.slope * cone.slope))),
        facing_sign(All(cone.FacingSign())) {}
  Vectors point, axis, tilt;
  Vectors on_axis;  // the direction outward from there
  Lane radius_m, slope, length, facing_sign;

  HWY_INLINE Lane Distance_m(const Vectors& p) const {
    const Vectors x = Minus(p, point);
    const Lane height_m = Dot(axis, x);
    const Lane squared = Dot(x, x) - height_m * height_m;
    const Lane away_m = hn::Sqrt(hn::Max(squared, hn::Zero(kTag)));
    return (away_m - radius_m - slope * height_m) / length;
  }
  HWY_INLINE Lane Cosine(const Vectors& p, const Vectors& n) const {
    const Vectors x = Minus(p, point);
    const Lane height_m = Dot(axis, x);
    const Vectors away{x.x - height_m * axis.x, x.y - height_m * axis.y, x.z - height_m * axis.z};
    const Lane away_m = hn::Sqrt(Dot(away, away));
    const LaneMask beside = hn::Gt(away_m, hn::Zero(kTag));
    const Vectors outward{hn::IfThenElse(beside, away.x / away_m, on_axis.x),
                          hn::IfThenElse(beside, away.y / away_m, on_axis.y),
                          hn::IfThenElse(beside, away.z / away_m, on_axis.z)};
    const Vectors normal{(outward.x - tilt.x) / length, (outward.y - tilt.y) / length,
                         (outward.z - tilt.z) / length};
    return facing_sign * Dot(normal, n);
  }
};

PlaneLanes InLanes(const PlaneModel& plane) { return PlaneLanes(plane); }
SphereLanes InLanes(const SphereModel& sphere) { return SphereLanes(sphere); }
ConeLanes InLanes(const CylinderModel& cylinder) { return ConeLanes(cylinder.AsCone()); }
ConeLanes InLanes(const ConeModel& cone) { return ConeLanes(cone); }

using Ranges = std::span<const PointLanes::Range>;

template <class Model>
HWY_INLINE void Append(const PointArrays& points, const Model& model,
                       const PointLanes::Range& range, Lane gate_scale, std::vector<Hit>& hits) {
  const auto load = [](const std::vector<double>& from, std::size_t i)
                        HWY_ATTR { return hn::LoadU(kTag, from.data() + i); };
  for (std::size_t i = range.begin; i < range.end; i += hn::Lanes(kTag)) {
    const Vectors p{load(points.x, i), load(points.y, i), load(points.z, i)};
    const Lane gate_m = gate_scale * load(points.gate_m, i);
    const Lane distance_m = model.Distance_m(p);
    const LaneMask near = hn::And(hn::Le(distance_m, gate_m), hn::Ge(distance_m, hn::Neg(gate_m)));
    if (hn::AllFalse(kTag, near)) continue;
    const Vectors n{load(points.nx, i), load(points.ny, i), load(points.nz, i)};
    const LaneMask hit = hn::And(near, hn::Ge(model.Cosine(p, n), load(points.min_cos, i)));
    alignas(32) double told_m[PointLanes::kMaxLanes];
    hn::Store(distance_m, kTag, told_m);
    for (unsigned bits = Bits(hit); bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
      if (i + lane >= range.end) break;
      hits.push_back({static_cast<std::uint32_t>(i + lane), told_m[lane]});
    }
  }
}

void Collect(const PointArrays& points, const AnyModel& model, Ranges ranges, double gate_scale,
             std::vector<Hit>& hits) {
  const auto collect = [&](const auto& m) HWY_ATTR {
    const auto in_lanes = InLanes(m);
    for (const PointLanes::Range& range : ranges) {
      Append(points, in_lanes, range, All(gate_scale), hits);
    }
  };
  std::visit(collect, model);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace cwm::perception
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cwm::perception {

HWY_EXPORT(Collect);

PointLanes::PointLanes(const ModelPoints& points) {
  for (std::uint32_t i = 0; i < points.size(); ++i) Add(points, i);
  Pad();
}

PointLanes::PointLanes(const ModelPoints& points, std::span<const std::uint32_t> listed) {
  for (std::uint32_t i : listed) Add(points, i);
  Pad();
}

void PointLanes::Add(const ModelPoints& points, std::uint32_t i) {
  ++size_;
  arrays_.x.push_back(points.p[i].x());
  arrays_.y.push_back(points.p[i].y());
  arrays_.z.push_back(points.p[i].z());
  arrays_.nx.push_back(points.n[i].x());
  arrays_.ny.push_back(points.n[i].y());
  arrays_.nz.push_back(points.n[i].z());
  arrays_.gate_m.push_back(points.gate_m[i]);
  arrays_.min_cos.push_back(points.min_cos[i]);
}

void PointLanes::Pad() {
  PointArrays& a = arrays_;
  for (std::vector<double>* values :
       {&a.x, &a.y, &a.z, &a.nx, &a.ny, &a.nz, &a.gate_m, &a.min_cos}) {
    values->resize(size_ + kMaxLanes, 0.0);
  }
}

std::vector<Hit> PointLanes::HitsIn(const AnyModel& model, std::span<const Range> ranges,
                                    double gate_scale) const {
  std::vector<Hit> hits;
  HWY_DYNAMIC_DISPATCH(Collect)(arrays_, model, ranges, gate_scale, hits);
  return hits;
}

}  // namespace cwm::perception
#endif  // HWY_ONCE
