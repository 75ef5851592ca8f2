// The errors of a depth camera that takes frame after frame: those of the device, the same in every
// frame, apart from those that each frame draws anew.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/cloud/sensor_noise.h"
#include "perception/simulation/noise_field.h"
#include "perception/simulation/range_image.h"

namespace cwm::perception {

// Errors that stay with the pixels of one device. Values as in SensorErrors.
struct DeviceErrors {
  SensorNoise noise = {};
  std::uint64_t seed = 0;
  NoiseField axial = {};
  NoiseField lateral_u = {};
  NoiseField lateral_v = {};
  std::vector<float> warp_m = {};  // along the ray
  NoiseField weakness = {};        // pixels of high values return in some frames only
};

// Draws the errors of a device that is a depth camera: a warp as DrawErrors has, and a fixed share
// of the axial and of the lateral noise. On a table at 0.9 m a Kinect deviates by 1.6 to 1.8 mm rms
// from the plane, the same in every frame.
DeviceErrors DrawDeviceErrors(const SensorNoise& noise, const PinholeCamera& camera,
                              std::uint64_t device_seed);

// The returns of a device from a view, before the errors of a frame.
struct DeviceReturn {
  float depth_m = 0;         // along the optical axis, with the errors of the device; 0: none
  float sigma_m = 0;         // of the frame's error of the depth
  float validity = 0;        // a frame has the return if a normal draw is less
  float lateral_px = 0;      // of the frame's lateral error; 0 except beside edges
  std::int32_t object = -1;  // index into the objects of the scene; -1: no return
};
struct DeviceReturns {
  int width = 0;
  int height = 0;
  std::vector<DeviceReturn> pixels;  // row-major
};

// Computes the returns of the rows [row_begin, row_end) of the image; `returns` has its size, and
// other rows are left as they are. The returns of a row depend on the image's rows from
// `kReturnRows` before to as many after it.
inline constexpr int kReturnRows = 8;
void ComputeReturns(const SimulatedScene& scene, const RangeImage& image,
                    const PinholeCamera& camera, const DeviceErrors& device, int row_begin,
                    int row_end, DeviceReturns& returns);

// The depths that a camera measured, row-major.
struct MeasuredDepth {
  int width = 0;
  int height = 0;
  std::vector<float> depth_m;  // along the optical axis; 0: no return
  // Per pixel, an index into the objects of the scene; kNoObject without a return, kMixedPixel if
  // the depth lies between two surfaces.
  std::vector<std::int32_t> object;
};
inline constexpr std::int32_t kNoObject = -1;
inline constexpr std::int32_t kMixedPixel = -2;

// Adds the errors of one frame. They are independent from frame to frame and correlated over 7
// pixels: on a surface that a Kinect sees at 0.9 m, face on, the mean over a square of 8 / 15 / 30
// / 46 / 76 mm changes by 0.87 / 0.74 / 0.55 / 0.42 / 0.29 mm rms from one frame to the next.
// Returns that are weak (at edges, on slanted and dark surfaces, and on some pixels of the device)
// are there in some frames only. The same seed gives the same bytes.
MeasuredDepth DrawFrame(const DeviceReturns& returns, const SensorNoise& noise,
                        std::uint64_t frame_seed);

}  // namespace cwm::perception
