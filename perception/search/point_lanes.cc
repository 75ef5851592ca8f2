#include "perception/search/point_lanes.h"

#include <variant>

#include "perception/cloud/double_lanes.h"

namespace cwm::perception {
namespace {

// Bit k: the k-th lane.
CWM_LANES_INLINE unsigned Bits(const DoubleMask& mask) {
  const DoubleMask bits = mask & DoubleMask{1, 2, 4, 8};
  return static_cast<unsigned>((bits[0] | bits[1]) | (bits[2] | bits[3]));
}

// What follows is each model's Distance_m and the cosine between its Normal, turned by its
// FacingSign, and the measured one, operation by operation.
struct PlaneLanes {
  explicit PlaneLanes(const PlaneModel& plane) : plane(plane) {}
  const PlaneModel& plane;

  CWM_LANES_INLINE Doubles Distance_m(const Vectors& p) const {
    return Dot(plane.normal, Minus(p, plane.point));
  }
  CWM_LANES_INLINE Doubles Cosine(const Vectors&, const Vectors& n) const {
    return Dot(plane.normal, n);
  }
};

struct SphereLanes {
  explicit SphereLanes(const SphereModel& sphere) : sphere(sphere) {}
  const SphereModel& sphere;

  CWM_LANES_INLINE Doubles Distance_m(const Vectors& p) const {
    const Vectors q = Minus(p, sphere.center);
    return Roots(Dot(q, q)) - sphere.radius_m;
  }
  CWM_LANES_INLINE Doubles Cosine(const Vectors& p, const Vectors& n) const {
    const Vectors q = Minus(p, sphere.center);
    const Doubles norm = Roots(Dot(q, q));
    const DoubleMask away = norm > Doubles{};
    const Vectors outward{Select(away, q.x / norm, Doubles{}), Select(away, q.y / norm, Doubles{}),
                          Select(away, q.z / norm, Doubles{} + 1.0)};
    return sphere.FacingSign() * Dot(outward, n);
  }
};

// A cylinder is a cone of slope 0: its distance and its normal come out the same.
struct ConeLanes {
  explicit ConeLanes(const ConeModel& cone)
      : cone(cone),
        length(std::sqrt(1 + cone.slope * cone.slope)),
        tilt(cone.slope * cone.axis),
        on_axis(BasisFromZ(cone.axis).col(0)) {}
  const ConeModel cone;
  const double length;
  const Vector3 tilt;
  const Vector3 on_axis;  // the direction outward from there

  CWM_LANES_INLINE Doubles Distance_m(const Vectors& p) const {
    const Vectors x = Minus(p, cone.point);
    const Doubles height_m = Dot(cone.axis, x);
    const Doubles squared = Dot(x, x) - height_m * height_m;
    const Doubles radius_m = Roots(Select(squared > Doubles{}, squared, Doubles{}));
    return (radius_m - cone.radius_m - cone.slope * height_m) / length;
  }
  CWM_LANES_INLINE Doubles Cosine(const Vectors& p, const Vectors& n) const {
    const Vectors x = Minus(p, cone.point);
    const Doubles height_m = Dot(cone.axis, x);
    const Vectors away{x.x - height_m * cone.axis.x(), x.y - height_m * cone.axis.y(),
                       x.z - height_m * cone.axis.z()};
    const Doubles away_m = Roots(Dot(away, away));
    const DoubleMask beside = away_m > Doubles{};
    const Vectors outward{Select(beside, away.x / away_m, Doubles{} + on_axis.x()),
                          Select(beside, away.y / away_m, Doubles{} + on_axis.y()),
                          Select(beside, away.z / away_m, Doubles{} + on_axis.z())};
    const Vectors normal{(outward.x - tilt.x()) / length, (outward.y - tilt.y()) / length,
                         (outward.z - tilt.z()) / length};
    return cone.FacingSign() * Dot(normal, n);
  }
};

PlaneLanes InLanes(const PlaneModel& plane) { return PlaneLanes(plane); }
SphereLanes InLanes(const SphereModel& sphere) { return SphereLanes(sphere); }
ConeLanes InLanes(const CylinderModel& cylinder) { return ConeLanes(cylinder.AsCone()); }
ConeLanes InLanes(const ConeModel& cone) { return ConeLanes(cone); }

}  // namespace

// The loop over a range of points.
struct LaneReader {
  const PointLanes& points;
  const double gate_scale;

  template <class Model>
  CWM_LANES_INLINE void Append(const Model& model, const PointLanes::Range& range,
                               std::vector<Hit>& hits) const {
    for (std::size_t i = range.begin; i < range.end; i += PointLanes::kLanes) {
      const Vectors p{LoadDoubles(&points.x_[i]), LoadDoubles(&points.y_[i]),
                      LoadDoubles(&points.z_[i])};
      const Doubles gate_m = gate_scale * LoadDoubles(&points.gate_m_[i]);
      const Doubles distance_m = model.Distance_m(p);
      const DoubleMask near = (distance_m <= gate_m) & (distance_m >= -gate_m);
      if (Bits(near) == 0) continue;
      const Vectors n{LoadDoubles(&points.nx_[i]), LoadDoubles(&points.ny_[i]),
                      LoadDoubles(&points.nz_[i])};
      const DoubleMask hit = near & (model.Cosine(p, n) >= LoadDoubles(&points.min_cos_[i]));
      for (unsigned bits = Bits(hit); bits != 0; bits &= bits - 1) {
        const auto lane = static_cast<std::size_t>(__builtin_ctz(bits));
        if (i + lane >= range.end) break;
        hits.push_back({static_cast<std::uint32_t>(i + lane), distance_m[lane]});
      }
    }
  }
};

namespace {

using Ranges = std::span<const PointLanes::Range>;

template <class Model>
CWM_LANES_INLINE std::vector<Hit> Collect(const LaneReader& reader, const Model& model,
                                          Ranges ranges) {
  std::vector<Hit> hits;
  for (const PointLanes::Range& range : ranges) reader.Append(model, range, hits);
  return hits;
}

#if defined(__x86_64__)
template <class Model>
__attribute__((target("avx2"))) std::vector<Hit> CollectWide(const LaneReader& reader,
                                                             const Model& model, Ranges ranges) {
  return Collect(reader, model, ranges);
}
#endif

template <class Model>
std::vector<Hit> HitsOf(const LaneReader& reader, const Model& model, Ranges ranges) {
#if defined(__x86_64__)
  if (HasWideLanes()) return CollectWide(reader, model, ranges);
#endif
  return Collect(reader, model, ranges);
}

}  // namespace

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
  x_.push_back(points.p[i].x());
  y_.push_back(points.p[i].y());
  z_.push_back(points.p[i].z());
  nx_.push_back(points.n[i].x());
  ny_.push_back(points.n[i].y());
  nz_.push_back(points.n[i].z());
  gate_m_.push_back(points.gate_m[i]);
  min_cos_.push_back(points.min_cos[i]);
}

void PointLanes::Pad() {
  for (std::vector<double>* values : {&x_, &y_, &z_, &nx_, &ny_, &nz_, &gate_m_, &min_cos_}) {
    values->resize(size_ + kLanes, 0.0);
  }
}

std::vector<Hit> PointLanes::HitsIn(const AnyModel& model, std::span<const Range> ranges,
                                    double gate_scale) const {
  const LaneReader reader{*this, gate_scale};
  return std::visit([&](const auto& m) { return HitsOf(reader, InLanes(m), ranges); }, model);
}

}  // namespace cwm::perception
