#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "perception/live/pixel_lanes.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include <limits>

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

void FindDeviationsInLanes(const std::uint8_t* classes, const BodyId* bodies, std::size_t count,
                           DeviatingPixels* words) {
  constexpr hn::CappedTag<std::uint8_t, kPixelsPerWord> kBytes;
  constexpr hn::Repartition<BodyId, decltype(kBytes)> kBodies;
  constexpr auto kConsistent = static_cast<std::uint8_t>(PixelClass::kConsistent);
  constexpr auto kMissing = static_cast<std::uint8_t>(PixelClass::kMissing);
  const auto consistent = hn::Set(kBytes, kConsistent);
  const auto missing = hn::Set(kBytes, kMissing);
  const auto word_of = [](const std::uint8_t* bytes) {
    std::uint64_t word = 0;
    for (std::size_t k = 0; k < sizeof(word); ++k) word |= std::uint64_t{bytes[k]} << (8 * k);
    return word;
  };
  std::size_t first = 0;
  for (; first + kPixelsPerWord <= count; first += kPixelsPerWord, ++words) {
    std::uint8_t are_missing[sizeof(std::uint64_t)];
    std::uint8_t are_others[sizeof(std::uint64_t)];
    for (std::size_t i = 0; i < kPixelsPerWord; i += hn::Lanes(kBytes)) {
      const auto pixels = hn::LoadU(kBytes, classes + first + i);
      const auto is_missing = hn::Eq(pixels, missing);
      const auto is_known = hn::Or(is_missing, hn::Eq(pixels, consistent));
      hn::StoreMaskBits(kBytes, is_missing, are_missing + i / 8);
      hn::StoreMaskBits(kBytes, hn::Not(is_known), are_others + i / 8);
    }
    const auto body = hn::Set(kBodies, bodies[first]);
    auto differences = hn::Zero(kBodies);
    for (std::size_t i = 0; i < kPixelsPerWord; i += hn::Lanes(kBodies)) {
      differences = hn::Or(differences, hn::Xor(body, hn::LoadU(kBodies, bodies + first + i)));
    }
    *words = {.missing = word_of(are_missing),
              .others = word_of(are_others),
              .is_one_body = hn::AllTrue(kBodies, hn::Eq(differences, hn::Zero(kBodies)))};
    words->missing_count = static_cast<int>(hwy::PopCount(words->missing));
  }
  if (first == count) return;
  *words = {};
  for (std::size_t i = first; i < count; ++i) {
    const std::uint64_t bit = std::uint64_t{1} << (i - first);
    if (classes[i] == kMissing) words->missing |= bit;
    if (classes[i] != kMissing && classes[i] != kConsistent) words->others |= bit;
  }
  words->missing_count = static_cast<int>(hwy::PopCount(words->missing));
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

void CopyKnownInLanes(const float* mean_m, const std::uint8_t* frames, std::size_t count,
                      float* known_m) {
  constexpr Wide kFloats;
  constexpr hn::RebindToSigned<Wide> kNumbers;
  constexpr hn::Rebind<std::uint8_t, Wide> kBytes;
  const auto unknown = hn::Inf(kFloats);
  const std::size_t lanes = hn::Lanes(kFloats);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto learnt = hn::PromoteTo(kNumbers, hn::LoadU(kBytes, frames + i));
    const auto is_unknown = hn::RebindMask(kFloats, hn::Eq(learnt, hn::Zero(kNumbers)));
    hn::StoreU(hn::IfThenElse(is_unknown, unknown, hn::LoadU(kFloats, mean_m + i)), kFloats,
               known_m + i);
  }
  for (; i < count; ++i) {
    known_m[i] = frames[i] == 0 ? std::numeric_limits<float>::infinity() : mean_m[i];
  }
}

void FindBendsInLanes(const DepthsAround& depths_m, std::size_t count, float* bends_m) {
  constexpr Group kFloats;
  const auto unknown = hn::Inf(kFloats);
  const auto two = hn::Set(kFloats, 2.0F);
  for (std::size_t i = 0; i < count; i += hn::Lanes(kFloats)) {
    const auto center = hn::LoadU(kFloats, depths_m[kBeside_px] + i);
    const auto at = [&](std::size_t row, std::size_t column) {
      const auto depth = hn::LoadU(kFloats, depths_m[row] + i + column - kBeside_px);
      return hn::IfThenElse(hn::Eq(depth, unknown), center, depth);
    };
    const auto doubled = two * center;
    auto bend = hn::Zero(kFloats);
    for (std::size_t step = 1; step <= kBeside_px; ++step) {
      const std::size_t before = kBeside_px - step;
      const std::size_t after = kBeside_px + step;
      const auto row = hn::Abs(at(kBeside_px, before) + at(kBeside_px, after) - doubled);
      const auto column = hn::Abs(at(before, kBeside_px) + at(after, kBeside_px) - doubled);
      const auto falling = hn::Abs(at(before, before) + at(after, after) - doubled);
      const auto rising = hn::Abs(at(after, before) + at(before, after) - doubled);
      bend = hn::Max(bend, hn::Max(hn::Max(row, column), hn::Max(falling, rising)));
    }
    hn::StoreU(bend, kFloats, bends_m + i);
  }
}

void FindExtremesInLanes(const DepthsAround& depths_m, std::size_t count, float* least_m,
                         float* greatest_m) {
  constexpr Group kFloats;
  const auto unknown = hn::Inf(kFloats);
  const auto below_all = hn::Neg(unknown);
  for (std::size_t i = 0; i < count; i += hn::Lanes(kFloats)) {
    auto least = unknown;
    auto greatest = below_all;
    for (const float* const row : depths_m) {
      for (std::size_t column = 0; column <= 2 * kBeside_px; ++column) {
        const auto depth = hn::LoadU(kFloats, row + i + column - kBeside_px);
        least = hn::Min(least, depth);
        greatest = hn::Max(greatest, hn::IfThenElse(hn::Eq(depth, unknown), below_all, depth));
      }
    }
    hn::StoreU(least, kFloats, least_m + i);
    hn::StoreU(greatest, kFloats, greatest_m + i);
  }
}

void SetGatesAboutInLanes(const ReferencePixels& pixels, const GateCenters& centers,
                          int mature_frames, std::size_t count, const LearningGains& gains) {
  constexpr Group kFloats;
  constexpr hn::RebindToSigned<Group> kNumbers;
  constexpr hn::Rebind<std::uint8_t, Group> kBytes;
  const auto prior_share = hn::Set(kFloats, gains.prior_share);
  const auto own_share = hn::Set(kFloats, 1 - gains.prior_share);
  const auto mature_gain = hn::Set(kFloats, gains.mean);
  const auto mature = hn::Set(kNumbers, mature_frames);
  const auto one = hn::Set(kFloats, 1.0F);
  const auto gate_sigma = hn::Set(kFloats, gains.gate_sigma);
  const auto least_low = hn::Set(kFloats, gains.least_low_m);
  const auto number = [&](const std::uint8_t* bytes) {
    return hn::PromoteTo(kNumbers, hn::LoadU(kBytes, bytes));
  };
  for (std::size_t i = 0; i < count; i += hn::Lanes(kFloats)) {
    const auto frames = number(centers.frames + i);
    const auto is_set =
        hn::RebindMask(kFloats, hn::Gt(number(centers.is_set + i), hn::Zero(kNumbers)));
    const auto is_edge =
        hn::RebindMask(kFloats, hn::Gt(number(centers.is_edge + i), hn::Zero(kNumbers)));
    const auto is_young = hn::RebindMask(kFloats, hn::Lt(frames, mature));
    const auto gain = hn::IfThenElse(is_young, one / hn::ConvertTo(kFloats, frames), mature_gain);
    const auto variance = own_share * hn::LoadU(kFloats, pixels.variance_m2 + i) +
                          prior_share * hn::LoadU(kFloats, pixels.prior_m2 + i);
    const auto gate = gate_sigma * hn::Sqrt(variance * (one + gain));
    const auto mean = hn::LoadU(kFloats, pixels.mean_m + i);
    const auto least = hn::IfThenElse(is_edge, hn::LoadU(kFloats, centers.least_m + i), mean);
    const auto greatest = hn::IfThenElse(is_edge, hn::LoadU(kFloats, centers.greatest_m + i), mean);
    const auto low = hn::Max(least - gate, least_low);
    const auto old_low = hn::LoadU(kFloats, pixels.low_m + i);
    const auto old_high = hn::LoadU(kFloats, pixels.high_m + i);
    hn::StoreU(hn::IfThenElse(is_set, low, old_low), kFloats, pixels.low_m + i);
    hn::StoreU(hn::IfThenElse(is_set, greatest + gate, old_high), kFloats, pixels.high_m + i);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace cwm::perception
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cwm::perception {

HWY_EXPORT(CompareInLanes);
HWY_EXPORT(FindDeviationsInLanes);
HWY_EXPORT(LearnInLanes);
HWY_EXPORT(SetGatesInLanes);
HWY_EXPORT(CopyKnownInLanes);
HWY_EXPORT(FindBendsInLanes);
HWY_EXPORT(FindExtremesInLanes);
HWY_EXPORT(SetGatesAboutInLanes);

void CompareWithGates(const float* depth_m, const float* low_m, const float* high_m,
                      std::size_t count, std::uint8_t* classes) {
  HWY_DYNAMIC_DISPATCH(CompareInLanes)(depth_m, low_m, high_m, count, classes);
}

void FindDeviations(const std::uint8_t* classes, const BodyId* bodies, std::size_t count,
                    DeviatingPixels* words) {
  HWY_DYNAMIC_DISPATCH(FindDeviationsInLanes)(classes, bodies, count, words);
}

void LearnDepths(const float* depth_m, const ReferencePixels& pixels, std::size_t count,
                 const LearningGains& gains) {
  HWY_DYNAMIC_DISPATCH(LearnInLanes)(depth_m, pixels, count, gains);
}

void SetGates(const ReferencePixels& pixels, std::size_t count, const LearningGains& gains) {
  HWY_DYNAMIC_DISPATCH(SetGatesInLanes)(pixels, count, gains);
}

void CopyKnown(const float* mean_m, const std::uint8_t* frames, std::size_t count, float* known_m) {
  HWY_DYNAMIC_DISPATCH(CopyKnownInLanes)(mean_m, frames, count, known_m);
}

void FindBends(const DepthsAround& depths_m, std::size_t count, float* bends_m) {
  HWY_DYNAMIC_DISPATCH(FindBendsInLanes)(depths_m, count, bends_m);
}

void FindExtremes(const DepthsAround& depths_m, std::size_t count, float* least_m,
                  float* greatest_m) {
  HWY_DYNAMIC_DISPATCH(FindExtremesInLanes)(depths_m, count, least_m, greatest_m);
}

void SetGatesAbout(const ReferencePixels& pixels, const GateCenters& centers, int mature_frames,
                   std::size_t count, const LearningGains& gains) {
  HWY_DYNAMIC_DISPATCH(SetGatesAboutInLanes)(pixels, centers, mature_frames, count, gains);
}

}  // namespace cwm::perception
#endif
