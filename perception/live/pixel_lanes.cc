#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "perception/live/pixel_lanes.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include "hwy/highway.h"
#include "perception/live/frame_classes.h"
#include "perception/live/pixel_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::perception {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Wide = hn::ScalableTag<float>;
using Group = hn::CappedTag<float, kPixelGroup>;

void CompareInLanes(const float* depth_m, const float* low_m, const float* high_m,
                    std::size_t count, std::uint8_t* classes) {
  constexpr Wide kFloats;
  constexpr hn::RebindToSigned<Wide> kNumbers;
  constexpr hn::Rebind<std::uint8_t, Wide> kBytes;
  constexpr auto kConsistent = static_cast<std::int32_t>(PixelClass::kConsistent);
  constexpr auto kMissing = static_cast<std::int32_t>(PixelClass::kMissing);
  const auto consistent = hn::Set(kNumbers, kConsistent);
  const auto missing = hn::Set(kNumbers, kMissing);
  const auto zero = hn::Zero(kFloats);
  const std::size_t lanes = hn::Lanes(kFloats);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto z = hn::LoadU(kFloats, depth_m + i);
    const auto within = hn::And(hn::Ge(z, hn::LoadU(kFloats, low_m + i)),
                                hn::Le(z, hn::LoadU(kFloats, high_m + i)));
    const auto number =
        hn::Or(hn::IfThenElseZero(hn::RebindMask(kNumbers, within), consistent),
               hn::IfThenElseZero(hn::RebindMask(kNumbers, hn::Eq(z, zero)), missing));
    hn::StoreU(hn::DemoteTo(kBytes, number), kBytes, classes + i);
  }
  for (; i < count; ++i) {
    const float z = depth_m[i];
    classes[i] = static_cast<std::uint8_t>((z >= low_m[i] && z <= high_m[i] ? kConsistent : 0) |
                                           (z == 0 ? kMissing : 0));
  }
}

void LearnInLanes(const float* depth_m, const ReferencePixels& pixels, std::size_t count,
                  const LearningGains& gains) {
  constexpr Group kFloats;
  const auto mean_gain = hn::Set(kFloats, gains.mean);
  const auto kept = hn::Set(kFloats, 1 - gains.mean);
  const auto spread_gain = hn::Set(kFloats, gains.spread);
  const auto validity_gain = hn::Set(kFloats, gains.validity);
  const auto one = hn::Set(kFloats, 1.0F);
  for (std::size_t i = 0; i < count; i += hn::Lanes(kFloats)) {
    const auto z = hn::LoadU(kFloats, depth_m + i);
    const auto within = hn::And(hn::Ge(z, hn::LoadU(kFloats, pixels.low_m + i)),
                                hn::Le(z, hn::LoadU(kFloats, pixels.high_m + i)));
    const auto validity = hn::LoadU(kFloats, pixels.validity + i);
    const auto seen = hn::IfThenElseZero(within, one);
    hn::StoreU(validity + (seen - validity) * validity_gain, kFloats, pixels.validity + i);
    const auto mean = hn::LoadU(kFloats, pixels.mean_m + i);
    const auto variance = hn::LoadU(kFloats, pixels.variance_m2 + i);
    const auto deviation = hn::IfThenElseZero(within, z - mean);
    const auto change = spread_gain * (kept * deviation * deviation - variance);
    hn::StoreU(variance + hn::IfThenElseZero(within, change), kFloats, pixels.variance_m2 + i);
    hn::StoreU(mean + mean_gain * deviation, kFloats, pixels.mean_m + i);
  }
}

void SetGatesInLanes(const ReferencePixels& pixels, std::size_t count, const LearningGains& gains) {
  constexpr Group kFloats;
  const auto prior_share = hn::Set(kFloats, gains.prior_share);
  const auto own_share = hn::Set(kFloats, 1 - gains.prior_share);
  const auto with_mean = hn::Set(kFloats, 1 + gains.mean);
  const auto gate_sigma = hn::Set(kFloats, gains.gate_sigma);
  const auto least_low = hn::Set(kFloats, gains.least_low_m);
  for (std::size_t i = 0; i < count; i += hn::Lanes(kFloats)) {
    const auto mean = hn::LoadU(kFloats, pixels.mean_m + i);
    const auto variance = own_share * hn::LoadU(kFloats, pixels.variance_m2 + i) +
                          prior_share * hn::LoadU(kFloats, pixels.prior_m2 + i);
    const auto gate = gate_sigma * hn::Sqrt(variance * with_mean);
    hn::StoreU(hn::Max(mean - gate, least_low), kFloats, pixels.low_m + i);
    hn::StoreU(mean + gate, kFloats, pixels.high_m + i);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace cwm::perception
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cwm::perception {

HWY_EXPORT(CompareInLanes);
HWY_EXPORT(LearnInLanes);
HWY_EXPORT(SetGatesInLanes);

void CompareWithGates(const float* depth_m, const float* low_m, const float* high_m,
                      std::size_t count, std::uint8_t* classes) {
  HWY_DYNAMIC_DISPATCH(CompareInLanes)(depth_m, low_m, high_m, count, classes);
}

void LearnDepths(const float* depth_m, const ReferencePixels& pixels, std::size_t count,
                 const LearningGains& gains) {
  HWY_DYNAMIC_DISPATCH(LearnInLanes)(depth_m, pixels, count, gains);
}

void SetGates(const ReferencePixels& pixels, std::size_t count, const LearningGains& gains) {
  HWY_DYNAMIC_DISPATCH(SetGatesInLanes)(pixels, count, gains);
}

}  // namespace cwm::perception
#endif
