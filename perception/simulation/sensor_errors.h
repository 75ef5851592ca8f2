// What a sensor's errors are made of: images of draws, biases, shadows. One value per pixel.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/cloud/sensor_noise.h"
#include "perception/simulation/noise_field.h"
#include "perception/simulation/range_image.h"

namespace cwm::perception {

// Neighbouring pixels this far apart in depth lie on two sides of an edge.
inline constexpr double kEdgeJump_m = 0.02;

// Of the SICK LMS400, as papers quote its data sheet: one standard deviation on bright and on dark
// surfaces, and the bound of a bias that stays the same over a scan.
inline constexpr double kSickBrightSigma_m = 0.003;
inline constexpr double kSickDarkSigma_m = 0.010;
inline constexpr double kSickBias_m = 0.004;

struct SensorErrors {
  NoiseField axial;      // in units of AxialSigma_m
  NoiseField lateral_u;  // in units of LateralSigma_m
  NoiseField lateral_v;
  std::vector<float> bias_m;  // along the ray, longer than true where positive
  std::vector<char> shadow;   // 1 where nothing can be measured
  // So near to a nearer surface, in pixels, a pixel shows that one: matched windows lie on both.
  std::vector<float> bleeding_px;  // empty: nowhere
};

// How pixels of a stereo camera err: alike where they are neighbours, as those of other cameras; or as
// windows are matched, each over many pixels: smooth over 11 and 6 pixels, with the shadow of the other
// imager, holes, and nearer surfaces that are some pixels too wide.
enum class StereoErrors { kPixels, kMatchedWindows };

// Cameras: fields of correlated noise, 4 pixels along rows and 2 along columns; kKinect and
// kRealSense with a warp of 1.3 mm rms over 0.2 m seen at 0.8 m; kKinect with the shadow of its
// projector; kTimeOfFlight with the bias of multipath. Lasers: each beam errs by itself. Of
// kTiltingLaser each row is a line of the scanner, and the tilt of the whole line errs by 0.05 to
// 0.1 degrees, drawn once per scan. kSickLms400 is 3 mm noisy on bright and 10 mm on dark objects,
// each drawn once, with a bias within 4 mm of the whole scan. `stereo` is of kRealSense alone.
SensorErrors DrawErrors(const SensorNoise& noise, const RangeImage& image,
                        const PinholeCamera& camera, std::uint64_t seed,
                        StereoErrors stereo = StereoErrors::kPixels);

}  // namespace cwm::perception
