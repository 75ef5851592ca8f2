// Highway's functions for one number as well, and vectors of numbers, so that a formula serves
// both: N is float, double or a vector of Highway's. Sources that include it are compiled with
// -ffp-contract=off: no product is fused with a sum, and every processor gives the same bits.
#if defined(CWM_LANE_MATH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef CWM_LANE_MATH_INL_H
#undef CWM_LANE_MATH_INL_H
#else
#define CWM_LANE_MATH_INL_H
#endif

#include <cmath>
#include <type_traits>

#include "collision/geometry/pose.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class N>
HWY_INLINE N All(double value) {
  if constexpr (std::is_floating_point_v<N>) {
    return static_cast<N>(value);
  } else {
    return hn::Set(hn::DFromV<N>(), static_cast<hn::TFromV<N>>(value));
  }
}

// For numbers, what hn has for vectors; hn's are found by their arguments.
template <class T>
concept Number = std::is_floating_point_v<T>;

template <Number T>
HWY_INLINE T Sqrt(T value) {
  return std::sqrt(value);
}
// The second where one of them is no number, as an x86 processor has it.
template <Number T>
HWY_INLINE T Max(T a, T b) {
  return a > b ? a : b;
}
template <Number T>
HWY_INLINE T Min(T a, T b) {
  return a < b ? a : b;
}
template <Number T>
HWY_INLINE T Abs(T value) {
  return std::abs(value);
}

template <Number T>
HWY_INLINE bool Le(T a, T b) {
  return a <= b;
}
template <Number T>
HWY_INLINE T IfThenElse(bool yes, T a, T b) {
  return yes ? a : b;
}

template <class N>
struct Triple {
  N x, y, z;
};

template <class N>
HWY_INLINE Triple<N> AllOf(const Vector3& v) {
  return {All<N>(v.x()), All<N>(v.y()), All<N>(v.z())};
}

template <class N>
HWY_INLINE Triple<N> Minus(const Triple<N>& a, const Triple<N>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

// Sums are taken in Eigen's order: the same bits.
template <class N>
HWY_INLINE N Dot(const Triple<N>& a, const Triple<N>& b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

}  // namespace cwm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
