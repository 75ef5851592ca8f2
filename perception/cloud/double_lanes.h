// Four doubles that are worked on at once, and vectors of them: as Lanes (lanes.h), without fused
// multiply-add, for loops over points.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "collision/geometry/pose.h"
#include "perception/cloud/lanes.h"

namespace cwm::perception {

inline constexpr std::size_t kDoubleLanes = kLanes * sizeof(float) / sizeof(double);

using Doubles = double __attribute__((vector_size(kDoubleLanes * sizeof(double))));
// All bits of a lane set: yes. Comparisons of Doubles give it.
using DoubleMask = std::int64_t __attribute__((vector_size(kDoubleLanes * sizeof(double))));

CWM_LANES_INLINE Doubles LoadDoubles(const double* from) {
  Doubles v;
  std::memcpy(&v, from, sizeof(v));
  return v;
}

CWM_LANES_INLINE void StoreDoubles(const Doubles& v, double* to) { std::memcpy(to, &v, sizeof(v)); }

CWM_LANES_INLINE Doubles Select(const DoubleMask& mask, const Doubles& yes, const Doubles& no) {
  return reinterpret_cast<Doubles>((mask & reinterpret_cast<DoubleMask>(yes)) |
                                   (~mask & reinterpret_cast<DoubleMask>(no)));
}

CWM_LANES_INLINE Doubles Larger(const Doubles& a, const Doubles& b) { return Select(a > b, a, b); }
CWM_LANES_INLINE Doubles Smaller(const Doubles& a, const Doubles& b) { return Select(a < b, a, b); }

CWM_LANES_INLINE Doubles Absolute(const Doubles& v) {
  return reinterpret_cast<Doubles>(reinterpret_cast<DoubleMask>(v) & 0x7fffffffffffffff);
}

CWM_LANES_INLINE Doubles Roots(const Doubles& v) {
  Doubles roots;
  for (std::size_t lane = 0; lane < kDoubleLanes; ++lane) roots[lane] = std::sqrt(v[lane]);
  return roots;
}

struct Vectors {
  Doubles x, y, z;
};

CWM_LANES_INLINE Vectors Minus(const Vectors& a, const Vector3& b) {
  return {a.x - b.x(), a.y - b.y(), a.z - b.z()};
}

// Sums are taken in Eigen's order: the same bits.
CWM_LANES_INLINE Doubles Dot(const Vectors& a, const Vectors& b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}
CWM_LANES_INLINE Doubles Dot(const Vector3& a, const Vectors& b) {
  return (a.x() * b.x + a.y() * b.y) + a.z() * b.z;
}

}  // namespace cwm::perception
