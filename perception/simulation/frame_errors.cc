#include "perception/simulation/frame_errors.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "perception/cloud/split_mix.h"
#include "perception/simulation/multipath.h"
#include "perception/simulation/random_draws.h"
#include "perception/simulation/sensor_errors.h"

namespace cwm::perception {
namespace {

// measured: a table seen by a stereo camera that stands still. It deviates by 1.6 to 1.8 mm rms
// from its plane, the same in every frame, and means over 8 / 15 / 30 / 46 / 76 mm move by 0.85 /
// 0.76 / 0.57 / 0.43 / 0.28 mm rms from frame to frame. derived: a field of correlation
// exp(-|du| / l) exp(-|dv| / l) with l = 12 mm and 0.76 mm rms fits these within 5 %; at the
// reference depth of 0.9 m, l is 7 pixels and the rms is this share of the Kinect's axial sigma.
constexpr double kFrameAxialShare = 0.454;
constexpr double kFrameCorrelation_px = 7;
// derived: with the warp of 1.3 mm and the lateral share, 1.6 to 1.8 mm at 0.9 m.
constexpr double kDeviceAxialShare = 0.6;
// chosen: the outline of a thing is ragged by a third of a pixel in the same way in all frames, and
// by as much anew in each. Together they are less than the lateral sigma of single scans, which
// would add 1.4 mm to the deviation of a slanted table.
constexpr double kDeviceLateralShare = 0.35;
constexpr double kFrameLateralShare = 0.4;
// chosen: lateral errors are at most as many rows as ComputeReturns looks at.
constexpr double kMaxShift_px = 4, kMaxFrameLateral_px = 2;
constexpr double kRowCorrelation_px = 4;  // of the device's errors, as in sensor_errors.cc
constexpr double kColumnCorrelation_px = 2;

// Validity: a frame has a return if its normal draw is less than this, minus what weakens it.
// measured: 15 % of the pixels of a stereo stream flicker, most of them at edges and on slanted and
// dark surfaces. chosen: the amounts, so that as many do in the scenes of this folder.
constexpr double kStrongReturn_sigma = 5;
constexpr double kWeakCorrelation_px = 3;
constexpr double kWeakFrom_sigma =
    1.0;                            // of the field of the device: a sixth of the pixels are above
constexpr double kWeakBy = 8;       // per sigma of the field above it ...
constexpr double kMaxWeakness = 6;  // ... up to this
constexpr double kMinEdgeWeakness = 2.5, kMaxEdgeWeakness = 5.5;
constexpr double kGrazingFrom_rad = 62 * std::numbers::pi / 180;
constexpr double kGrazingTo_rad = 82 * std::numbers::pi / 180;
constexpr double kGrazingBy = 7;             // at kGrazingTo_rad
constexpr double kDarkShare = 0.15;          // of the objects
constexpr double kDarkWeakFrom_sigma = 0.5;  // on dark surfaces: a third
constexpr double kValidityCorrelation_px = 1.5;

// chosen: share of the pixels at an edge that mix both sides, as in virtual_scanner.cc.
constexpr double kMixedByMatching = 0.1;
constexpr double kMixedByAveraging = 0.5;

// Streams of the device's seed and of a frame's.
enum DeviceStream : std::uint64_t {
  kDeviceAxial = 0,
  kDeviceLateralU = 1,
  kDeviceLateralV = 2,
  kDeviceWeakness = 8,
  kDeviceDarkness = 2000  // and those after it, one per object
};
enum FrameStream : std::uint64_t { kFrameAxial = 1, kFrameValidity = 2, kFrameEdges = 3 };

NoiseField DeviceField(const PinholeCamera& camera, std::uint64_t seed, DeviceStream stream,
                       double row_px, double column_px) {
  RandomDraws draws(seed, stream);
  return ExponentialField(camera.width, camera.height, row_px, column_px, draws);
}

std::uint64_t SeedOf(std::uint64_t frame_seed, FrameStream stream) {
  return MixBits(frame_seed ^ MixBits(kGoldenGamma * stream));
}

// By object, the value of the device's field from which its pixels are weak.
std::vector<double> WeakFrom_sigma(std::size_t object_count, std::uint64_t seed) {
  std::vector<double> weak_from;
  for (std::size_t i = 0; i < object_count; ++i) {
    RandomDraws draws(seed, kDeviceDarkness + i);
    weak_from.push_back(draws.Uniform() < kDarkShare ? kDarkWeakFrom_sigma : kWeakFrom_sigma);
  }
  return weak_from;
}

// A draw in [0, 1) for a pixel.
double PixelDraw(std::uint64_t seed, std::size_t pixel) {
  return static_cast<double>(MixBits(seed + kGoldenGamma * (pixel + 1)) >> 11) * 0x1.0p-53;
}

class ReturnComputer {
 public:
  ReturnComputer(const SimulatedScene& scene, const RangeImage& image, const PinholeCamera& camera,
                 const DeviceErrors& device, int row_begin, int row_end)
      : image_(image),
        camera_(camera),
        device_(device),
        nearest_m_(RangeOf(device.noise.model).nearest_m),
        weak_from_(WeakFrom_sigma(scene.objects.size(), device.seed)),
        shadow_(ProjectorShadow(device.noise, image, camera, std::max(0, row_begin - kReturnRows),
                                std::min(image.height, row_end + kReturnRows))) {
    for (const SimulatedObject& object : scene.objects) {
      shiny_.push_back(object.finish == Finish::kShiny);
    }
    if (device.noise.model == SensorModel::kTimeOfFlight) bias_m_ = MultipathBias(image, camera);
  }

  DeviceReturn Compute(int u, int v) const {
    const Sighting& own = image_.at(u, v);
    const Vector3 ray = RayDirection(camera_, u, v);
    // Beside an object, the noise of a surface at one metre decides if the pixel hits it.
    const double depth_m = own.seen() ? own.depth_m : 1;
    const double incidence_rad = own.seen() ? Incidence_rad(own, ray) : 0;
    const double lateral_px =
        device_.noise.LateralSigma_m(depth_m, incidence_rad) * camera_.focal_px / depth_m;
    const bool edge = IsBesideEdge(u, v);
    const float frame_lateral_px =
        edge ? static_cast<float>(std::min(kFrameLateralShare * lateral_px, kMaxFrameLateral_px))
             : 0.F;
    const auto source = Sample(u + Shift_px(lateral_px, device_.lateral_u.at(u, v)),
                               v + Shift_px(lateral_px, device_.lateral_v.at(u, v)));
    if (!source) return {.lateral_px = frame_lateral_px};
    const std::size_t i = Index(u, v);
    const double sigma_m = device_.noise.AxialSigma_m(source->depth_m, source->incidence_rad);
    double error_m = kDeviceAxialShare * sigma_m * device_.axial.values[i];
    if (!device_.warp_m.empty()) error_m += device_.warp_m[i];
    if (!bias_m_.empty()) error_m += bias_m_[i];
    const double per_ray = 1 / ray.norm();  // depth, of a length along the ray
    return {.depth_m = static_cast<float>(source->depth_m + error_m * per_ray),
            .sigma_m = static_cast<float>(kFrameAxialShare * sigma_m * per_ray),
            .validity = static_cast<float>(kStrongReturn_sigma - Weakness(i, *source, edge)),
            .lateral_px = frame_lateral_px,
            .object = source->object};
  }

 private:
  struct Source {
    double depth_m = 0;
    double incidence_rad = 0;
    std::int32_t object = kNoObject;
  };

  static double Incidence_rad(const Sighting& sighting, const Vector3& ray) {
    const double cosine = -sighting.normal_C.cast<double>().dot(ray) / ray.norm();
    return std::acos(std::clamp(cosine, 0.0, 1.0));
  }

  static double Shift_px(double lateral_px, double draw) {
    return std::clamp(kDeviceLateralShare * lateral_px * draw, -kMaxShift_px, kMaxShift_px);
  }

  // The surface at a place between pixels, on the tangent plane of the nearest one.
  std::optional<Source> Sample(double u_px, double v_px) const {
    const int u = std::clamp(static_cast<int>(std::lround(u_px)), 0, image_.width - 1);
    const int v = std::clamp(static_cast<int>(std::lround(v_px)), 0, image_.height - 1);
    const Sighting& source = image_.at(u, v);
    if (!source.seen() || source.depth_m < nearest_m_ ||
        shiny_[static_cast<std::size_t>(source.object)] != 0 || shadow_[Index(u, v)] != 0) {
      return std::nullopt;
    }
    const Vector3 center = RayDirection(camera_, u, v);
    const double incidence_rad = Incidence_rad(source, center);
    if (incidence_rad >= kGrazingTo_rad) return std::nullopt;
    const Vector3 normal = source.normal_C.cast<double>();
    const double slant = normal.dot(center) / normal.dot(RayDirection(camera_, u_px, v_px));
    return Source{
        .depth_m = source.depth_m * slant, .incidence_rad = incidence_rad, .object = source.object};
  }

  bool IsBesideEdge(int u, int v) const {
    const Sighting& own = image_.at(u, v);
    for (int dv = -1; dv <= 1; ++dv) {
      for (int du = -1; du <= 1; ++du) {
        if (!image_.contains(u + du, v + dv)) continue;
        const Sighting& beside = image_.at(u + du, v + dv);
        if (beside.seen() != own.seen() || std::abs(beside.depth_m - own.depth_m) > kEdgeJump_m) {
          return true;
        }
      }
    }
    return false;
  }

  double Weakness(std::size_t pixel, const Source& source, bool edge) const {
    const double grazing =
        (source.incidence_rad - kGrazingFrom_rad) / (kGrazingTo_rad - kGrazingFrom_rad);
    const double weak_from = weak_from_[static_cast<std::size_t>(source.object)];
    double weakness =
        std::clamp(kWeakBy * (device_.weakness.values[pixel] - weak_from), 0.0, kMaxWeakness) +
        kGrazingBy * std::max(0.0, grazing);
    if (edge) {
      weakness += std::lerp(kMinEdgeWeakness, kMaxEdgeWeakness, PixelDraw(device_.seed, pixel));
    }
    return weakness;
  }

  std::size_t Index(int u, int v) const { return static_cast<std::size_t>(v) * image_.width + u; }

  const RangeImage& image_;
  const PinholeCamera& camera_;
  const DeviceErrors& device_;
  double nearest_m_;
  std::vector<double> weak_from_;  // by object
  std::vector<char> shiny_;
  std::vector<char> shadow_;
  std::vector<float> bias_m_;  // empty: none
};

// Lateral errors and mixed pixels beside edges.
class EdgeErrors {
 public:
  EdgeErrors(const DeviceReturns& returns, double mixed_share, std::uint64_t seed)
      : returns_(returns), mixed_share_(mixed_share), seed_(seed) {}

  // The return that the pixel (u, v) beside an edge has in this frame.
  DeviceReturn At(int u, int v) const {
    std::uint64_t state = MixBits(seed_ + kGoldenGamma * (Index(u, v) + 1));
    const auto uniform = [&] {
      return static_cast<double>(NextRandomBits(state) >> 11) * 0x1.0p-53;
    };
    const DeviceReturn& own = returns_.pixels[Index(u, v)];
    const double radius_px = own.lateral_px * std::sqrt(-2 * std::log(1 - uniform()));
    const double angle_rad = 2 * std::numbers::pi * uniform();
    DeviceReturn found = returns_.pixels[Index(
        std::clamp(static_cast<int>(std::lround(u + radius_px * std::cos(angle_rad))), 0,
                   returns_.width - 1),
        std::clamp(static_cast<int>(std::lround(v + radius_px * std::sin(angle_rad))), 0,
                   returns_.height - 1))];
    if (found.object >= 0 && uniform() < mixed_share_) Mix(u, v, uniform(), found);
    return found;
  }

 private:
  // At an edge the measurement may lie between the two sides and belongs to neither.
  void Mix(int u, int v, double weight, DeviceReturn& found) const {
    for (const auto& [du, dv] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      if (u + du < 0 || u + du >= returns_.width || v + dv < 0 || v + dv >= returns_.height) {
        continue;
      }
      const DeviceReturn& beside = returns_.pixels[Index(u + du, v + dv)];
      if (beside.object < 0 || std::abs(beside.depth_m - found.depth_m) < kEdgeJump_m) continue;
      found.depth_m = std::lerp(found.depth_m, beside.depth_m, static_cast<float>(weight));
      found.object = kMixedPixel;
      return;
    }
  }

  std::size_t Index(int u, int v) const { return static_cast<std::size_t>(v) * returns_.width + u; }

  const DeviceReturns& returns_;
  double mixed_share_;
  std::uint64_t seed_;
};

}  // namespace

DeviceErrors DrawDeviceErrors(const SensorNoise& noise, const PinholeCamera& camera,
                              std::uint64_t device_seed) {
  DeviceErrors device{.noise = noise, .seed = device_seed};
  device.noise.image_width_px = camera.width;
  device.axial =
      DeviceField(camera, device_seed, kDeviceAxial, kRowCorrelation_px, kColumnCorrelation_px);
  device.lateral_u =
      DeviceField(camera, device_seed, kDeviceLateralU, kRowCorrelation_px, kColumnCorrelation_px);
  device.lateral_v =
      DeviceField(camera, device_seed, kDeviceLateralV, kRowCorrelation_px, kColumnCorrelation_px);
  if (Triangulates(noise.model)) device.warp_m = Warp_m(camera, device_seed);
  device.weakness =
      DeviceField(camera, device_seed, kDeviceWeakness, kWeakCorrelation_px, kWeakCorrelation_px);
  return device;
}

void ComputeReturns(const SimulatedScene& scene, const RangeImage& image,
                    const PinholeCamera& camera, const DeviceErrors& device, int row_begin,
                    int row_end, DeviceReturns& returns) {
  const ReturnComputer computer(scene, image, camera, device, row_begin, row_end);
  std::size_t i = static_cast<std::size_t>(row_begin) * image.width;
  for (int v = row_begin; v < row_end; ++v) {
    for (int u = 0; u < image.width; ++u) returns.pixels[i++] = computer.Compute(u, v);
  }
}

MeasuredDepth DrawFrame(const DeviceReturns& returns, const SensorNoise& noise,
                        std::uint64_t frame_seed) {
  const NoiseField axial = QuickField(returns.width, returns.height, kFrameCorrelation_px,
                                      SeedOf(frame_seed, kFrameAxial));
  const NoiseField validity = QuickField(returns.width, returns.height, kValidityCorrelation_px,
                                         SeedOf(frame_seed, kFrameValidity));
  const EdgeErrors edges(returns, Triangulates(noise.model) ? kMixedByMatching : kMixedByAveraging,
                         SeedOf(frame_seed, kFrameEdges));
  MeasuredDepth frame{
      .width = returns.width, .height = returns.height, .depth_m = {}, .object = {}};
  frame.depth_m.resize(returns.pixels.size(), 0);
  frame.object.resize(returns.pixels.size(), kNoObject);
  std::size_t i = 0;
  for (int v = 0; v < returns.height; ++v) {
    for (int u = 0; u < returns.width; ++u, ++i) {
      const DeviceReturn& own = returns.pixels[i];
      const DeviceReturn found = own.lateral_px > 0 ? edges.At(u, v) : own;
      if (found.object == kNoObject || validity.values[i] > found.validity) continue;
      frame.depth_m[i] = found.depth_m + found.sigma_m * axial.values[i];
      frame.object[i] = found.object;
    }
  }
  return frame;
}

}  // namespace cwm::perception
