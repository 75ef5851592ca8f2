#include "perception/simulation/virtual_scanner.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "perception/simulation/noise_field.h"
#include "perception/simulation/random_draws.h"
#include "perception/simulation/range_image.h"

namespace cwm::perception {
namespace {

// Measured on the tables of real Kinect scans: residuals are correlated about like this.
constexpr double kRowCorrelation_px = 4;
constexpr double kColumnCorrelation_px = 2;
constexpr double kWarpLength_m = 0.2;  // the warp is slow over this distance, seen at ...
constexpr double kWarpDepth_m = 0.8;   // ... this depth

constexpr double kRandomDropOut = 0.015;
constexpr double kFirstGrazing_rad = 70 * std::numbers::pi / 180;  // drop-outs begin ...
constexpr double kLastGrazing_rad = 85 * std::numbers::pi / 180;   // ... and nothing is left

// Neighbouring pixels this far apart in depth lie on two sides of an edge.
constexpr double kEdgeJump_m = 0.02;
// Share of the pixels at an edge that mix both sides. Stereo matchers decide for one side nearly
// always; a beam that is averaged over its footprint mixes about half of the time.
constexpr double kMixedByMatching = 0.1;
constexpr double kMixedByAveraging = 0.5;

// Of the Kinect's infrared projector, to the camera.
constexpr double kProjectorBaseline_m = 0.075;
constexpr double kProjectorNearest_m = 0.3;  // nearer, its pattern is too bright to be matched

bool Triangulates(SensorModel model) {
  return model == SensorModel::kKinect || model == SensorModel::kRealSense;
}

struct NoiseFields {
  NoiseField axial;
  NoiseField lateral_u;
  NoiseField lateral_v;
  NoiseField warp;
};

NoiseFields DrawFields(const PinholeCamera& camera, std::uint64_t seed) {
  const auto field = [&](std::uint64_t stream) {
    RandomDraws draws(seed, stream);
    return ExponentialField(camera.width, camera.height, kRowCorrelation_px, kColumnCorrelation_px,
                            draws);
  };
  RandomDraws warp_draws(seed, 3);
  return {.axial = field(0),
          .lateral_u = field(1),
          .lateral_v = field(2),
          .warp = WarpField(camera.width, camera.height,
                            camera.focal_px * kWarpLength_m / kWarpDepth_m, warp_draws)};
}

double Incidence_rad(const Sighting& sighting, const Vector3& direction) {
  const double cosine = -sighting.normal_C.cast<double>().dot(direction.normalized());
  return std::acos(std::clamp(cosine, 0.0, 1.0));
}

double GrazingDropOut(double incidence_rad) {
  return std::clamp((incidence_rad - kFirstGrazing_rad) / (kLastGrazing_rad - kFirstGrazing_rad),
                    0.0, 1.0);
}

// Pixels that the projector does not reach: on each row, what another surface hides from a point
// one baseline to the left of the camera. Rows of camera and projector coincide, so that this is a
// depth test over the projector's columns.
std::vector<char> ProjectorShadow(const RangeImage& image, const PinholeCamera& camera) {
  const auto projector_column = [&](int u, double depth_m) {
    return std::lround(u + camera.focal_px * kProjectorBaseline_m / depth_m);
  };
  const long column_count = projector_column(image.width, kProjectorNearest_m) + 1;
  std::vector<char> shadow(image.pixels.size(), 0);
  std::vector<double> nearest_m;
  for (int v = 0; v < image.height; ++v) {
    nearest_m.assign(column_count, std::numeric_limits<double>::infinity());
    for (int u = 0; u < image.width; ++u) {
      const Sighting& pixel = image.at(u, v);
      if (pixel.depth_m < kProjectorNearest_m) continue;  // also where nothing is seen
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
  return shadow;
}

// One measured pixel before the noise along the ray.
struct Return {
  double depth_m = 0;
  double incidence_rad = 0;
  std::int32_t object = -1;
  std::int32_t part = -1;
};

class NoisyCamera {
 public:
  NoisyCamera(const RangeImage& image, const PinholeCamera& camera, const ScanOptions& options)
      : image_(image),
        camera_(camera),
        noise_(options.noise),
        fields_(DrawFields(camera, options.seed)),
        drop_draws_(options.seed, 4),
        shadow_(noise_.model == SensorModel::kKinect ? ProjectorShadow(image, camera)
                                                     : std::vector<char>(image.pixels.size(), 0)) {}

  // Pixels in the order of the rows: the draws depend on it.
  std::optional<Return> Measure(int u, int v) {
    const double drop = drop_draws_.Uniform();
    const double mix = drop_draws_.Uniform();
    const double mix_weight = drop_draws_.Uniform();
    std::optional<Return> found = Displaced(u, v);
    if (!found) return std::nullopt;
    if (drop < std::max(kRandomDropOut, GrazingDropOut(found->incidence_rad))) return std::nullopt;
    const double share = Triangulates(noise_.model) ? kMixedByMatching : kMixedByAveraging;
    if (mix < share) Mix(u, v, mix_weight, *found);
    return found;
  }

  Eigen::Vector3f Place(int u, int v, const Return& found) const {
    const Vector3 direction = RayDirection(camera_, u, v);
    double error_m =
        noise_.AxialSigma_m(found.depth_m, found.incidence_rad) * fields_.axial.at(u, v);
    if (Triangulates(noise_.model)) error_m += kSlowWarp_m * fields_.warp.at(u, v);
    return (found.depth_m * direction + error_m * direction.normalized()).cast<float>();
  }

 private:
  // Lateral noise: the pixel measures the surface along a ray that is a little beside its own.
  std::optional<Return> Displaced(int u, int v) const {
    const Sighting& own = image_.at(u, v);
    // Beside an object the noise of a surface at one metre decides whether the pixel catches it.
    const double depth_m = own.seen() ? own.depth_m : 1;
    const double incidence_rad = own.seen() ? Incidence_rad(own, RayDirection(camera_, u, v)) : 0;
    if (GrazingDropOut(incidence_rad) >= 1) return std::nullopt;
    const double sigma_px =
        noise_.LateralSigma_m(depth_m, incidence_rad) * camera_.focal_px / depth_m;
    const double source_u = u + sigma_px * fields_.lateral_u.at(u, v);
    const double source_v = v + sigma_px * fields_.lateral_v.at(u, v);
    return Sample(source_u, source_v);
  }

  // The surface at a place between pixels: the tangent plane of the nearest one.
  std::optional<Return> Sample(double u_px, double v_px) const {
    const int u = std::clamp(static_cast<int>(std::lround(u_px)), 0, image_.width - 1);
    const int v = std::clamp(static_cast<int>(std::lround(v_px)), 0, image_.height - 1);
    const Sighting& source = image_.at(u, v);
    if (!source.seen() || shadow_[static_cast<std::size_t>(v) * image_.width + u]) {
      return std::nullopt;
    }
    const Vector3 center = RayDirection(camera_, u, v);
    const double incidence_rad = Incidence_rad(source, center);
    if (GrazingDropOut(incidence_rad) >= 1) return std::nullopt;
    const Vector3 normal = source.normal_C.cast<double>();
    const double slant = normal.dot(center) / normal.dot(RayDirection(camera_, u_px, v_px));
    return Return{.depth_m = source.depth_m * slant,
                  .incidence_rad = incidence_rad,
                  .object = source.object,
                  .part = source.part};
  }

  // At an edge the measurement falls between its two sides and belongs to neither.
  void Mix(int u, int v, double weight, Return& found) const {
    for (const auto& [du, dv] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      if (!image_.contains(u + du, v + dv)) continue;
      const Sighting& beside = image_.at(u + du, v + dv);
      if (!beside.seen() || std::abs(beside.depth_m - found.depth_m) < kEdgeJump_m) continue;
      found.depth_m = std::lerp(found.depth_m, beside.depth_m, weight);
      found.object = found.part = -1;
      return;
    }
  }

  const RangeImage& image_;
  const PinholeCamera& camera_;
  SensorNoise noise_;
  NoiseFields fields_;
  RandomDraws drop_draws_;
  std::vector<char> shadow_;
};

SimulatedCloud EmptyCloud(const PinholeCamera& camera) {
  const std::size_t count = static_cast<std::size_t>(camera.width) * camera.height;
  SimulatedCloud scan;
  scan.cloud.width = camera.width;
  scan.cloud.height = camera.height;
  scan.cloud.points.assign(count,
                           Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  scan.object.assign(count, -1);
  scan.part.assign(count, -1);
  return scan;
}

}  // namespace

SimulatedCloud Scan(const SimulatedScene& scene, const PinholeCamera& camera,
                    const ScanOptions& options) {
  assert(camera.width > 0 && camera.height > 0 && camera.focal_px > 0);
  const RangeImage image = Render(scene, camera);
  std::optional<NoisyCamera> noisy;
  if (!options.noiseless) noisy.emplace(image, camera, options);
  SimulatedCloud scan = EmptyCloud(camera);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * camera.width + u;
      const Sighting& ideal = image.pixels[i];
      std::optional<Return> found;
      if (noisy) {
        found = noisy->Measure(u, v);
      } else if (ideal.seen()) {
        found = {.depth_m = ideal.depth_m, .object = ideal.object, .part = ideal.part};
      }
      if (!found) continue;
      scan.cloud.points[i] =
          noisy ? noisy->Place(u, v, *found)
                : Eigen::Vector3f((found->depth_m * RayDirection(camera, u, v)).cast<float>());
      scan.object[i] = found->object;
      scan.part[i] = found->part;
    }
  }
  return scan;
}

}  // namespace cwm::perception
