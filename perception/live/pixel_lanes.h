// The loops over all pixels of a frame, in the widest registers of the machine: a frame in which
// nothing changed costs little else. The same bits on every processor.
#pragma once

#include <cstddef>
#include <cstdint>

namespace cwm::perception {

// Writes for each of `count` pixels PixelClass::kConsistent if its depth is within [low_m, high_m],
// kMissing if its depth is 0, and 0 otherwise.
void CompareWithGates(const float* depth_m, const float* low_m, const float* high_m,
                      std::size_t count, std::uint8_t* classes);

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

}  // namespace cwm::perception
