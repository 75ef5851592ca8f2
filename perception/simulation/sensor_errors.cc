#include "perception/simulation/sensor_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "perception/simulation/multipath.h"

namespace cwm::perception {
namespace {

// measured: the correlation of residuals on the tables of real Kinect scans.
constexpr double kRowCorrelation_px = 4;
constexpr double kColumnCorrelation_px = 2;
constexpr double kWarpLength_m = 0.2;  // the warp is slow over this distance, seen at ...
constexpr double kWarpDepth_m = 0.8;   // ... this depth

// The Kinect's infrared projector: its distance from the camera.
constexpr double kProjectorBaseline_m = 0.075;
constexpr double kProjectorNearest_m = 0.3;  // nearer, its pattern is too bright to be matched

// measured: on level parts of real D435 images: correlation 0.93, 0.84, 0.74, 0.46 at 1, 2, 4, 8
// pixels along rows, 0.86, 0.76, 0.50, 0 along columns; 8 to 10 % of a cluttered image are holes.
constexpr double kStereoRowCorrelation_px = 11;
constexpr double kStereoColumnCorrelation_px = 6;
constexpr double kStereoBaseline_m = 0.05;
constexpr double kHoleCorrelation_px = 8;
constexpr double kHoleThreshold_sigma = 2.1;  // 1.8 % of the image besides shadows
// Matching windows are several pixels wide: nearer surfaces grow by two pixels on average, with a
// local variation.
constexpr double kBleeding_px = 2, kBleedingSigma_px = 1;

// The jitter of the lines of a tilting laser.
constexpr double kMinJitter_rad = 0.05 * std::numbers::pi / 180;
constexpr double kMaxJitter_rad = 0.10 * std::numbers::pi / 180;

// Streams of one seed; virtual_scanner.cc draws from stream 4.
enum Stream : std::uint64_t {
  kAxialStream = 0,
  kLateralUStream = 1,
  kLateralVStream = 2,
  kWarpStream = 3,
  kJitterStream = 5,
  kBiasStream = 6,
  kHoleStream = 1001,
  kBleedingStream = 1002,
  kBrightnessStream = 7  // and those after it, one per object
};

NoiseField EmptyField(const PinholeCamera& camera) {
  return {.width = camera.width,
          .height = camera.height,
          .values = std::vector<float>(static_cast<std::size_t>(camera.width) * camera.height, 0)};
}

NoiseField CorrelatedField(const PinholeCamera& camera, std::uint64_t seed, Stream stream,
                           double row_px = kRowCorrelation_px,
                           double column_px = kColumnCorrelation_px) {
  RandomDraws draws(seed, stream);
  return ExponentialField(camera.width, camera.height, row_px, column_px, draws);
}

NoiseField IndependentField(const PinholeCamera& camera, std::uint64_t seed, Stream stream) {
  RandomDraws draws(seed, stream);
  NoiseField field = EmptyField(camera);
  for (float& value : field.values) value = static_cast<float>(draws.Normal());
  return field;
}

// The shadow of one row: places that another surface hides from a point one baseline to the left of
// the camera. The rows of both coincide, so this is a depth test over the projector's columns.
// `nearest_m` is room for that.
void ShadeRow(double baseline_m, const RangeImage& image, const PinholeCamera& camera, int v,
              std::vector<double>& nearest_m, std::vector<char>& shadow) {
  const auto projector_column = [&](int u, double depth_m) {
    return std::lround(u + camera.focal_px * baseline_m / depth_m);
  };
  const long column_count = projector_column(image.width, kProjectorNearest_m) + 1;
  nearest_m.assign(column_count, std::numeric_limits<double>::infinity());
  for (int u = 0; u < image.width; ++u) {
    const Sighting& pixel = image.at(u, v);
    if (pixel.depth_m < kProjectorNearest_m) continue;  // also if nothing is seen
    const Sighting& next = image.at(std::min(u + 1, image.width - 1), v);
    const bool connected = std::abs(next.depth_m - pixel.depth_m) < kEdgeJump_m;
    const long begin = projector_column(u, pixel.depth_m);
    const long end = connected ? projector_column(u + 1, next.depth_m) : begin;
    for (long c = std::max(0L, std::min(begin, end)); c <= std::max(begin, end); ++c) {
      if (c < column_count) nearest_m[c] = std::min(nearest_m[c], pixel.depth_m);
    }
  }
  for (int u = 0; u < image.width; ++u) {
    const double depth_m = image.at(u, v).depth_m;
    if (depth_m < kProjectorNearest_m) continue;
    shadow[static_cast<std::size_t>(v) * image.width + u] =
        depth_m > nearest_m[projector_column(u, depth_m)] + kEdgeJump_m;
  }
}

std::vector<char> ShadowFrom(double baseline_m, const RangeImage& image,
                             const PinholeCamera& camera) {
  std::vector<char> shadow(image.pixels.size(), 0);
  std::vector<double> nearest_m;
  for (int v = 0; v < image.height; ++v) {
    ShadeRow(baseline_m, image, camera, v, nearest_m, shadow);
  }
  return shadow;
}

// One draw per row, scaled to units of LateralSigma_m.
NoiseField LineJitter(const SensorNoise& noise, const PinholeCamera& camera, std::uint64_t seed) {
  RandomDraws draws(seed, kJitterStream);
  const double jitter_rad = draws.Uniform(kMinJitter_rad, kMaxJitter_rad);
  const double scale = jitter_rad / noise.LateralSigma_m(1);  // across the ray at one metre
  NoiseField field = EmptyField(camera);
  for (int v = 0; v < camera.height; ++v) {
    const auto begin = field.values.begin() + static_cast<std::ptrdiff_t>(v) * camera.width;
    std::fill_n(begin, camera.width, static_cast<float>(scale * draws.Normal()));
  }
  return field;
}

// Scales the draws of each object to its own sigma.
void DarkenObjects(const SensorNoise& noise, const RangeImage& image, std::uint64_t seed,
                   NoiseField& axial) {
  std::vector<float> scale_of;  // grows with the largest object index seen
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const std::int32_t object = image.pixels[i].object;
    if (object < 0) continue;
    while (scale_of.size() <= static_cast<std::size_t>(object)) {
      RandomDraws draws(seed, kBrightnessStream + scale_of.size());
      const double sigma_m = draws.Uniform(kSickBrightSigma_m, kSickDarkSigma_m);
      scale_of.push_back(static_cast<float>(sigma_m / noise.AxialSigma_m(1)));
    }
    axial.values[i] *= scale_of[static_cast<std::size_t>(object)];
  }
}

float ConstantBias_m(std::uint64_t seed) {
  RandomDraws draws(seed, kBiasStream);
  return static_cast<float>(draws.Uniform(-kSickBias_m, kSickBias_m));
}

void DrawCameraErrors(const SensorNoise& noise, const PinholeCamera& camera, std::uint64_t seed,
                      SensorErrors& errors) {
  errors.axial = CorrelatedField(camera, seed, kAxialStream);
  errors.lateral_u = CorrelatedField(camera, seed, kLateralUStream);
  errors.lateral_v = CorrelatedField(camera, seed, kLateralVStream);
  if (Triangulates(noise.model)) errors.bias_m = Warp_m(camera, seed);
}

void MatchWindows(const RangeImage& image, const PinholeCamera& camera, std::uint64_t seed,
                  SensorErrors& errors) {
  errors.axial = CorrelatedField(camera, seed, kAxialStream, kStereoRowCorrelation_px,
                                 kStereoColumnCorrelation_px);
  errors.shadow = ShadowFrom(kStereoBaseline_m, image, camera);
  const NoiseField holes =
      CorrelatedField(camera, seed, kHoleStream, kHoleCorrelation_px, kHoleCorrelation_px);
  const NoiseField wider =
      CorrelatedField(camera, seed, kBleedingStream, kHoleCorrelation_px, kHoleCorrelation_px);
  errors.bleeding_px.resize(holes.values.size());
  for (std::size_t i = 0; i < holes.values.size(); ++i) {
    if (holes.values[i] > kHoleThreshold_sigma) errors.shadow[i] = 1;
    errors.bleeding_px[i] =
        static_cast<float>(std::max(0.0, kBleeding_px + kBleedingSigma_px * wider.values[i]));
  }
}

}  // namespace

std::vector<float> Warp_m(const PinholeCamera& camera, std::uint64_t seed) {
  RandomDraws draws(seed, kWarpStream);
  std::vector<float> warp_m =
      WarpField(camera.width, camera.height, camera.focal_px * kWarpLength_m / kWarpDepth_m, draws)
          .values;
  for (float& value : warp_m) value *= static_cast<float>(kSlowWarp_m);
  return warp_m;
}

std::vector<char> ProjectorShadow(const SensorNoise& noise, const RangeImage& image,
                                  const PinholeCamera& camera, int row_begin, int row_end) {
  std::vector<char> shadow(image.pixels.size(), 0);
  if (noise.model != SensorModel::kKinect) return shadow;
  std::vector<double> nearest_m;
  for (int v = row_begin; v < row_end; ++v) {
    ShadeRow(kProjectorBaseline_m, image, camera, v, nearest_m, shadow);
  }
  return shadow;
}

SensorErrors DrawErrors(const SensorNoise& noise, const RangeImage& image,
                        const PinholeCamera& camera, std::uint64_t seed, StereoErrors stereo) {
  SensorErrors errors{.axial = {},
                      .lateral_u = {},
                      .lateral_v = {},
                      .bias_m = std::vector<float>(image.pixels.size(), 0),
                      .shadow = std::vector<char>(image.pixels.size(), 0),
                      .bleeding_px = {}};
  switch (noise.model) {
    case SensorModel::kKinect:
      DrawCameraErrors(noise, camera, seed, errors);
      errors.shadow = ProjectorShadow(noise, image, camera, 0, image.height);
      break;
    case SensorModel::kTimeOfFlight:
      DrawCameraErrors(noise, camera, seed, errors);
      errors.bias_m = MultipathBias(image, camera);
      break;
    case SensorModel::kRealSense:
      DrawCameraErrors(noise, camera, seed, errors);
      if (stereo == StereoErrors::kMatchedWindows) {
        MatchWindows(image, camera, seed, errors);
      }
      break;
    case SensorModel::kGiven:
      DrawCameraErrors(noise, camera, seed, errors);
      break;
    case SensorModel::kTiltingLaser:
      errors.axial = IndependentField(camera, seed, kAxialStream);
      errors.lateral_u = EmptyField(camera);
      errors.lateral_v = LineJitter(noise, camera, seed);
      break;
    case SensorModel::kSickLms400:
      errors.axial = IndependentField(camera, seed, kAxialStream);
      errors.lateral_u = IndependentField(camera, seed, kLateralUStream);
      errors.lateral_v = IndependentField(camera, seed, kLateralVStream);
      DarkenObjects(noise, image, seed, errors.axial);
      std::fill(errors.bias_m.begin(), errors.bias_m.end(), ConstantBias_m(seed));
      break;
  }
  return errors;
}

}  // namespace cwm::perception
