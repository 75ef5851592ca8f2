#include "perception/whole/solid_lanes.h"

#include <array>
#include <cassert>
#include <limits>
#include <optional>
#include <variant>

#include "collision/geometry/revolved_profile.h"
#include "perception/cloud/double_lanes.h"

namespace cwm::perception {
namespace {

struct BallLanes {
  explicit BallLanes(const Sphere& ball) : radius_m(ball.radius_m) {}
  double radius_m;

  CWM_LANES_INLINE Doubles Distance_m(const Vectors& p) const {
    return Roots(Dot(p, p)) - radius_m;
  }
};

struct BoxLanes {
  explicit BoxLanes(const Box& box) : half_m(0.5 * box.size_m) {}
  Vector3 half_m;

  CWM_LANES_INLINE Doubles Distance_m(const Vectors& p) const {
    const Doubles zero{};
    const Vectors beyond{Absolute(p.x) - half_m.x(), Absolute(p.y) - half_m.y(),
                         Absolute(p.z) - half_m.z()};
    const Vectors outside{Larger(beyond.x, zero), Larger(beyond.y, zero), Larger(beyond.z, zero)};
    const Doubles most = Larger(Larger(beyond.x, beyond.y), beyond.z);
    return Roots(Dot(outside, outside)) + Smaller(most, zero);
  }
};

// A convex solid of revolution: the nearest of the sides of its profile, or, within all of them,
// the plane that is least deep.
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

  CWM_LANES_INLINE Doubles Distance_m(const Vectors& p) const {
    const Doubles zero{}, one = zero + 1.0;
    const Doubles radial = Roots(p.x * p.x + p.y * p.y);
    Doubles highest = zero - std::numeric_limits<double>::infinity();
    Doubles nearest = zero + std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < count; ++k) {
      const ProfileSide& side = sides[k];
      const Doubles x = radial - side.a.x(), y = p.z - side.a.y();
      highest = Larger(highest, x * side.outward.x() + y * side.outward.y());
      const Doubles way = (x * side.along.x() + y * side.along.y()) / side.squared_length_m2;
      const Doubles share = Smaller(Larger(way, zero), one);
      const Doubles dx = x - share * side.along.x(), dy = y - share * side.along.y();
      nearest = Smaller(nearest, dx * dx + dy * dy);
    }
    return Select(highest <= zero, highest, Roots(nearest));
  }
};

}  // namespace

struct PlaceReader {
  const PlaceLanes& places;
  const Pose& X_SP;
  std::span<double> out_m;

  template <class Solid>
  CWM_LANES_INLINE void Read(const Solid& solid) const {
    const Matrix3& R = X_SP.linear();
    const Vector3& t = X_SP.translation();
    for (std::size_t i = 0; i < places.size_; i += kDoubleLanes) {
      const Vectors p{LoadDoubles(&places.x_[i]), LoadDoubles(&places.y_[i]),
                      LoadDoubles(&places.z_[i])};
      const Vectors p_S{Dot(R.row(0).transpose(), p) + t.x(), Dot(R.row(1).transpose(), p) + t.y(),
                        Dot(R.row(2).transpose(), p) + t.z()};
      const Doubles distance_m = solid.Distance_m(p_S);
      if (i + kDoubleLanes <= out_m.size()) {
        StoreDoubles(distance_m, &out_m[i]);
      } else {
        for (std::size_t lane = 0; i + lane < out_m.size(); ++lane)
          out_m[i + lane] = distance_m[lane];
      }
    }
  }
};

namespace {

#if defined(__x86_64__)
template <class Solid>
__attribute__((target("avx2"))) void ReadWide(const PlaceReader& reader, const Solid& solid) {
  reader.Read(solid);
}
#endif

template <class Solid>
void Read(const PlaceReader& reader, const Solid& solid) {
#if defined(__x86_64__)
  if (HasWideLanes()) return ReadWide(reader, solid);
#endif
  reader.Read(solid);
}

}  // namespace

PlaceLanes::PlaceLanes(std::span<const Vector3> places) : size_(places.size()) {
  for (const Vector3& p : places) {
    x_.push_back(p.x());
    y_.push_back(p.y());
    z_.push_back(p.z());
  }
  for (std::vector<double>* values : {&x_, &y_, &z_}) values->resize(size_ + kDoubleLanes, 0.0);
}

void PlaceLanes::DistancesTo(const Shape& solid, const Pose& X_SP,
                             std::span<double> distance_m) const {
  assert(distance_m.size() == size_);
  const PlaceReader reader{*this, X_SP, distance_m};
  if (const auto* ball = std::get_if<Sphere>(&solid)) return Read(reader, BallLanes(*ball));
  if (const auto* box = std::get_if<Box>(&solid)) return Read(reader, BoxLanes(*box));
  if (const auto* cone = std::get_if<Cone>(&solid)) return Read(reader, RevolvedLanes(*cone));
  Read(reader, RevolvedLanes(std::get<Cylinder>(solid)));
}

}  // namespace cwm::perception
