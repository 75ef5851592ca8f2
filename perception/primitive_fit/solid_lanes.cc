#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "perception/primitive_fit/solid_lanes.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include <algorithm>
#include <array>
#include <cassert>
#include <optional>
#include <variant>

#include "collision/geometry/revolved_profile.h"
#include "collision/geometry/solid_distance-inl.h"
#include "hwy/highway.h"
#include "perception/primitive_fit/solid_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::perception {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using cwm::HWY_NAMESPACE::AllOf;
using Tag = hn::CappedTag<double, PlaceLanes::kMaxLanes>;
using Lane = hn::Vec<Tag>;
using Vectors = cwm::HWY_NAMESPACE::Triple<Lane>;
constexpr Tag kTag;

struct BallLanes {
  explicit BallLanes(const Sphere& ball) : radius_m(hn::Set(kTag, ball.radius_m)) {}
  Lane radius_m;

  HWY_INLINE Lane Distance_m(const Vectors& p) const { return DistanceToSphere_m(p, radius_m); }
};

struct BoxLanes {
  explicit BoxLanes(const Box& box) : half_m(AllOf<Lane>(0.5 * box.size_m)) {}
  Vectors half_m;

  HWY_INLINE Lane Distance_m(const Vectors& p) const { return DistanceToBox_m(p, half_m); }
};

struct RevolvedLanes {
  template <class Solid>
  explicit RevolvedLanes(const Solid& solid) {
    const auto profile = ProfileOf(solid);
    for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
      const std::optional<ProfileSide> side = ProfileSide::Between(profile[i], profile[i + 1]);
      if (side) sides[count++] = *side;
    }
  }
  std::array<ProfileSide, 3> sides;
  std::size_t count = 0;

  HWY_INLINE Lane Distance_m(const Vectors& p) const {
    const Lane radial = hn::Sqrt(p.x * p.x + p.y * p.y);
    return cwm::HWY_NAMESPACE::DistanceToRevolved_m({sides.data(), count}, radial, p.z);
  }
};

template <class Solid>
void Read(const PlaceArrays& places, const Pose& X_SP, const Solid& solid,
          std::span<double> out_m) {
  const Matrix3& R = X_SP.linear();
  const Vector3& t = X_SP.translation();
  const Vectors rows[] = {AllOf<Lane>(R.row(0).transpose()), AllOf<Lane>(R.row(1).transpose()),
                          AllOf<Lane>(R.row(2).transpose())};
  const Vectors origin = AllOf<Lane>(t);
  const std::size_t lanes = hn::Lanes(kTag);
  for (std::size_t i = 0; i < out_m.size(); i += lanes) {
    const Vectors p{hn::LoadU(kTag, &places.x[i]), hn::LoadU(kTag, &places.y[i]),
                    hn::LoadU(kTag, &places.z[i])};
    const Lane distance_m = solid.Distance_m(
        {Dot(rows[0], p) + origin.x, Dot(rows[1], p) + origin.y, Dot(rows[2], p) + origin.z});
    if (i + lanes <= out_m.size()) {
      hn::StoreU(distance_m, kTag, &out_m[i]);
    } else {
      alignas(32) double told_m[PlaceLanes::kMaxLanes];
      hn::Store(distance_m, kTag, told_m);
      std::copy_n(told_m, out_m.size() - i, &out_m[i]);
    }
  }
}

void ReadAny(const PlaceArrays& places, const Pose& X_SP, const Shape& solid,
             std::span<double> out_m) {
  if (const auto* ball = std::get_if<Sphere>(&solid)) {
    return Read(places, X_SP, BallLanes(*ball), out_m);
  }
  if (const auto* box = std::get_if<Box>(&solid)) {
    return Read(places, X_SP, BoxLanes(*box), out_m);
  }
  if (const auto* cone = std::get_if<Cone>(&solid)) {
    return Read(places, X_SP, RevolvedLanes(*cone), out_m);
  }
  Read(places, X_SP, RevolvedLanes(std::get<Cylinder>(solid)), out_m);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace cwm::perception
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cwm::perception {

HWY_EXPORT(ReadAny);

PlaceLanes::PlaceLanes(std::span<const Vector3> places) : size_(places.size()) {
  for (const Vector3& p : places) {
    arrays_.x.push_back(p.x());
    arrays_.y.push_back(p.y());
    arrays_.z.push_back(p.z());
  }
  for (std::vector<double>* values : {&arrays_.x, &arrays_.y, &arrays_.z}) {
    values->resize(size_ + kMaxLanes, 0.0);
  }
}

void PlaceLanes::DistancesTo(const Shape& solid, const Pose& X_SP,
                             std::span<double> distance_m) const {
  assert(distance_m.size() == size_);
  HWY_DYNAMIC_DISPATCH(ReadAny)(arrays_, X_SP, solid, distance_m);
}

}  // namespace cwm::perception
#endif  // HWY_ONCE
