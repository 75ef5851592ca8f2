// The loops over all pixels of a frame, in the widest registers of the machine: a frame in which
// nothing changed costs little else. The same bits on every processor.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "perception/live/known_body.h"

namespace cwm::perception {

// Writes for each of `count` pixels PixelClass::kConsistent if its depth is within [low_m, high_m],
// kMissing if its depth is 0, and 0 otherwise.
void CompareWithGates(const float* depth_m, const float* low_m, const float* high_m,
                      std::size_t count, std::uint8_t* classes);

// The pixels of 64 successive ones that are not consistent, a bit each, the first one's the lowest.
inline constexpr std::size_t kPixelsPerWord = 64;
struct DeviatingPixels {
  std::uint64_t missing = 0;  // PixelClass::kMissing
  std::uint64_t others = 0;   // neither that nor kConsistent
  int missing_count = 0;
  bool is_one_body = false;  // all 64 are expected to show the same body
};
// Writes a word for each 64 of `count` pixels; bits beyond the last one are 0.
void FindDeviations(const std::uint8_t* classes, const BodyId* bodies, std::size_t count,
                    DeviatingPixels* words);

// What a reference image knows of successive pixels; each pointer is to the first one's.
struct ReferencePixels {
  float* mean_m = nullptr;
  float* variance_m2 = nullptr;
  float* validity = nullptr;
  float* low_m = nullptr;
  float* high_m = nullptr;
  const float* prior_m2 = nullptr;  // the variance that the noise model tells at the mean
};

// The gains of pixels whose mean is known well, from 0 to 1.
struct LearningGains {
  float mean = 0, spread = 0, validity = 0;
  float prior_share = 0;  // of the noise model in the variance of a gate
  float gate_sigma = 0;   // half the width of a gate
  float least_low_m = 0;
};

// Every function below takes a multiple of this many pixels.
inline constexpr std::size_t kPixelGroup = 8;

// Lets the means, variances and validities follow the depths. A depth outside of the pixel's gates
// is no return.
void LearnDepths(const float* depth_m, const ReferencePixels& pixels, std::size_t count,
                 const LearningGains& gains);
// Sets the gates of pixels that are no edges from their means and variances.
void SetGates(const ReferencePixels& pixels, std::size_t count, const LearningGains& gains);

// The depths about successive pixels of a row: rows[kBeside_px] is their own. Each row has
// kBeside_px more depths before its first pixel and after its last one. Infinite: not known, which
// counts as the depth of the pixel in the middle.
inline constexpr std::size_t kBeside_px = 2;
using DepthsAround = std::array<const float*, 2 * kBeside_px + 1>;

// Writes the means of pixels that have learnt any frame, and infinity for the others. Takes any
// number of pixels.
void CopyKnown(const float* mean_m, const std::uint8_t* frames, std::size_t count, float* known_m);
// Writes for each pixel the greatest of the second differences of depth through it, along its row,
// its column and its diagonals, 1 and kBeside_px pixels apart, in metres; not a number for an
// unknown one.
void FindBends(const DepthsAround& depths_m, std::size_t count, float* bends_m);
// Writes the least and the greatest of the depths around each pixel.
void FindExtremes(const DepthsAround& depths_m, std::size_t count, float* least_m,
                  float* greatest_m);

// Tells which of successive pixels get new gates, 0 or 1, and the depths that these are about.
struct GateCenters {
  const std::uint8_t* is_set = nullptr;
  const std::uint8_t* frames = nullptr;   // learnt, at least 1 for a pixel that is set
  const std::uint8_t* is_edge = nullptr;  // 1: about [least_m, greatest_m], else about the mean
  const float* least_m = nullptr;
  const float* greatest_m = nullptr;
};
// As SetGates for the pixels that are set. The mean of one that has learnt fewer than
// `mature_frames` is known the less the fewer they are.
void SetGatesAbout(const ReferencePixels& pixels, const GateCenters& centers, int mature_frames,
                   std::size_t count, const LearningGains& gains);

}  // namespace cwm::perception
