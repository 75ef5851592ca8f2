// The components of a sensor's errors: images of draws, biases, shadows, with one value per pixel.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/cloud/sensor_noise.h"
#include "perception/simulation/noise_field.h"
#include "perception/simulation/range_image.h"

namespace cwm::perception {

// Neighbouring pixels with this difference in depth are on two sides of an edge.
inline constexpr double kEdgeJump_m = 0.02;

// cited: papers that quote the SICK LMS400's data sheet: one standard deviation on bright and on
// dark surfaces, and the bound of a bias that is constant over a scan.
inline constexpr double kSickBrightSigma_m = 0.003;
inline constexpr double kSickDarkSigma_m = 0.010;
inline constexpr double kSickBias_m = 0.004;

struct SensorErrors {
  NoiseField axial;      // in units of AxialSigma_m
  NoiseField lateral_u;  // in units of LateralSigma_m
  NoiseField lateral_v;
  std::vector<float> bias_m;  // along the ray; positive if the range is too long
  std::vector<char> shadow;   // 1 if nothing can be measured
  // The distance, in pixels, at which a pixel shows a nearer surface, because matching windows
  // cover both.
  std::vector<float> bleeding_px;  // empty: no bleeding
};

// The errors of a stereo camera: correlated between neighbouring pixels, like those of other
// cameras; or those of window matching over many pixels: smooth over 11 and 6 pixels, with the
// shadow of the other imager, holes, and nearer surfaces that are some pixels too wide.
enum class StereoErrors { kPixels, kMatchedWindows };

// The slow warp of a camera that triangulates, metres along the ray: 1.3 mm rms over 0.2 m seen at
// 0.8 m.
std::vector<float> Warp_m(const PinholeCamera& camera, std::uint64_t seed);

// 1 per pixel of the given rows that the sensor's projector does not reach, on each row places that
// another surface hides from it; 0 elsewhere, and for all sensors but kKinect.
std::vector<char> ProjectorShadow(const SensorNoise& noise, const RangeImage& image,
                                  const PinholeCamera& camera, int row_begin, int row_end);

// Draws the errors of a scan. Cameras: fields of correlated noise, 4 pixels along rows and 2 along
// columns; kKinect and kRealSense with a warp of 1.3 mm rms over 0.2 m seen at 0.8 m; kKinect with
// the shadow of its projector; kTimeOfFlight with the bias of multipath. Lasers: each beam has an
// independent error. Each row of kTiltingLaser is a line of the scanner, and the tilt of a whole
// line has an error of 0.05 to 0.1 degrees, drawn once per scan. kSickLms400 has a noise of 3 mm on
// bright to 10 mm on dark objects, drawn once per object, and a bias within 4 mm of the whole scan.
// `stereo` only applies to kRealSense.
SensorErrors DrawErrors(const SensorNoise& noise, const RangeImage& image,
                        const PinholeCamera& camera, std::uint64_t seed,
                        StereoErrors stereo = StereoErrors::kPixels);

}  // namespace cwm::perception
