// The radius of a normal's neighbourhood (normals.h), of one point or of several in lanes.
#if defined(CWM_NORMAL_RADIUS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef CWM_NORMAL_RADIUS_INL_H
#undef CWM_NORMAL_RADIUS_INL_H
#else
#define CWM_NORMAL_RADIUS_INL_H
#endif

#include <numbers>

#include "collision/geometry/lane_math-inl.h"
#include "perception/cloud/normals.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::perception::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using cwm::HWY_NAMESPACE::All;

// Roots of positive numbers, to some roundings: two steps of Newton's from a guess by the exponent, a
// third of which is the root's.
template <class V>
HWY_INLINE V CubeRoot(V v) {
  // cited: two thirds of the exponent's bias of 127, in its place, less what makes the guess err
  // equally to both sides (W. Kahan, as in the C library of FreeBSD).
  constexpr float kThirdOfBias = 709958130.0f;
  const hn::DFromV<V> real;
  const hn::RebindToSigned<decltype(real)> whole;
  const V bits = hn::ConvertTo(real, hn::BitCast(whole, v));
  const V guess = bits / All<V>(3) + All<V>(kThirdOfBias);
  V root = hn::BitCast(real, hn::ConvertTo(whole, guess));
  for (int i = 0; i < 2; ++i) root = (All<V>(2) * root + v / (root * root)) / All<V>(3);
  return root;
}

template <class V>
HWY_INLINE V NormalRadius_m(V sigma_m, V spacing_m) {
  constexpr float kFactor = kNormalBend_m * 4 * std::numbers::inv_sqrtpi_v<float>;
  return hn::Min(All<V>(kNormalRadius_sigma) * sigma_m,
                 CubeRoot(All<V>(kFactor) * sigma_m * spacing_m));
}

}  // namespace cwm::perception::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
