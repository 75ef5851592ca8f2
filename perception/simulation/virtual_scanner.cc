#include "perception/simulation/virtual_scanner.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "perception/simulation/random_draws.h"
#include "perception/simulation/range_image.h"
#include "perception/simulation/sensor_errors.h"

namespace cwm::perception {
namespace {

constexpr double kRandomDropOut = 0.015;
constexpr double kFirstGrazing_rad = 70 * std::numbers::pi / 180;  // drop-outs begin ...
constexpr double kLastGrazing_rad = 85 * std::numbers::pi / 180;   // ... and all returns are lost

// Share of the pixels at an edge that mix both sides. Stereo matchers nearly always select one
// side; a beam that is averaged over its footprint mixes them about half of the time.
constexpr double kMixedByMatching = 0.1;
constexpr double kMixedByAveraging = 0.5;

constexpr std::uint64_t kDropOutStream = 4;  // of the seed; sensor_errors.cc uses others

bool IsShiny(const SimulatedScene& scene, std::int32_t object) {
  return scene.objects[static_cast<std::size_t>(object)].finish == Finish::kShiny;
}

double Incidence_rad(const Sighting& sighting, const Vector3& direction) {
  const double cosine = -sighting.normal_C.cast<double>().dot(direction.normalized());
  return std::acos(std::clamp(cosine, 0.0, 1.0));
}

double GrazingDropOut(double incidence_rad) {
  return std::clamp((incidence_rad - kFirstGrazing_rad) / (kLastGrazing_rad - kFirstGrazing_rad),
                    0.0, 1.0);
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
  NoisyCamera(const SimulatedScene& scene, const RangeImage& image, const PinholeCamera& camera,
              const ScanOptions& options)
      : scene_(scene),
        image_(image),
        camera_(camera),
        noise_(options.noise),
        errors_(DrawErrors(
            options.noise, image, camera, options.seed,
            options.matches_windows ? StereoErrors::kMatchedWindows : StereoErrors::kPixels)),
        drop_draws_(options.seed, kDropOutStream) {}

  // Call this for the pixels in the order of the rows, on which the draws depend.
  std::optional<Return> Measure(int u, int v) {
    const double drop = drop_draws_.Uniform();
    const double mix = drop_draws_.Uniform();
    const double mix_weight = drop_draws_.Uniform();
    std::optional<Return> found = Displaced(u, v);
    if (const auto beside = NearerBeside(u, v, found)) found = beside;
    if (!found) return std::nullopt;
    if (drop < std::max(kRandomDropOut, GrazingDropOut(found->incidence_rad))) return std::nullopt;
    const double share = Triangulates(noise_.model) ? kMixedByMatching : kMixedByAveraging;
    if (mix < share) Mix(u, v, mix_weight, *found);
    return found;
  }

  Eigen::Vector3f Place(int u, int v, const Return& found) const {
    const Vector3 direction = RayDirection(camera_, u, v);
    const double error_m =
        noise_.AxialSigma_m(found.depth_m, found.incidence_rad) * errors_.axial.at(u, v) +
        errors_.bias_m[Index(u, v)];
    return (found.depth_m * direction + error_m * direction.normalized()).cast<float>();
  }

 private:
  // Lateral noise: the pixel measures the surface along a ray slightly beside its own.
  std::optional<Return> Displaced(int u, int v) const {
    const Sighting& own = image_.at(u, v);
    // Beside an object, the noise of a surface at one metre decides if the pixel hits it.
    const double depth_m = own.seen() ? own.depth_m : 1;
    const double incidence_rad = own.seen() ? Incidence_rad(own, RayDirection(camera_, u, v)) : 0;
    if (GrazingDropOut(incidence_rad) >= 1) return std::nullopt;
    const double sigma_px =
        noise_.LateralSigma_m(depth_m, incidence_rad) * camera_.focal_px / depth_m;
    const double source_u = u + sigma_px * errors_.lateral_u.at(u, v);
    const double source_v = v + sigma_px * errors_.lateral_v.at(u, v);
    return Sample(source_u, source_v);
  }

  // The surface at a place between pixels, on the tangent plane of the nearest one.
  std::optional<Return> Sample(double u_px, double v_px) const {
    const int u = std::clamp(static_cast<int>(std::lround(u_px)), 0, image_.width - 1);
    const int v = std::clamp(static_cast<int>(std::lround(v_px)), 0, image_.height - 1);
    const Sighting& source = image_.at(u, v);
    if (!source.seen() || errors_.shadow[Index(u, v)] != 0 || IsShiny(source.object)) {
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

  // The nearer surface that bleeds into this pixel, if any. The measured place is on no surface.
  std::optional<Return> NearerBeside(int u, int v, const std::optional<Return>& own) const {
    if (errors_.bleeding_px.empty() || errors_.shadow[Index(u, v)] != 0) return std::nullopt;
    const float reach_px = errors_.bleeding_px[Index(u, v)];
    const int max_px = static_cast<int>(reach_px);
    const double depth_m = own ? own->depth_m : std::numeric_limits<double>::infinity();
    std::optional<Return> nearest;
    for (int dv = -max_px; dv <= max_px; ++dv) {
      for (int du = -max_px; du <= max_px; ++du) {
        if (!image_.contains(u + du, v + dv) || std::hypot(du, dv) > reach_px) continue;
        const Sighting& beside = image_.at(u + du, v + dv);
        if (!beside.seen() || IsShiny(beside.object)) continue;
        const double limit_m = nearest ? nearest->depth_m : depth_m - kEdgeJump_m;
        if (beside.depth_m < limit_m) {
          nearest = Return{.depth_m = beside.depth_m, .incidence_rad = 0};
        }
      }
    }
    return nearest;
  }

  // At an edge the measurement lies between the two sides and belongs to neither.
  void Mix(int u, int v, double weight, Return& found) const {
    for (const auto& [du, dv] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      if (!image_.contains(u + du, v + dv)) continue;
      const Sighting& beside = image_.at(u + du, v + dv);
      if (!beside.seen() || IsShiny(beside.object) ||
          std::abs(beside.depth_m - found.depth_m) < kEdgeJump_m) {
        continue;
      }
      found.depth_m = std::lerp(found.depth_m, beside.depth_m, weight);
      found.object = found.part = -1;
      return;
    }
  }

  bool IsShiny(std::int32_t object) const { return perception::IsShiny(scene_, object); }

  std::size_t Index(int u, int v) const { return static_cast<std::size_t>(v) * image_.width + u; }

  const SimulatedScene& scene_;
  const RangeImage& image_;
  const PinholeCamera& camera_;
  SensorNoise noise_;
  SensorErrors errors_;
  RandomDraws drop_draws_;
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
  ScanOptions of_image = options;
  of_image.noise.image_width_px = camera.width;
  if (!options.noiseless) noisy.emplace(scene, image, camera, of_image);
  SimulatedCloud scan = EmptyCloud(camera);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * camera.width + u;
      const Sighting& ideal = image.pixels[i];
      std::optional<Return> found;
      if (noisy) {
        found = noisy->Measure(u, v);
      } else if (ideal.seen() && !IsShiny(scene, ideal.object)) {
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
