#include "perception/simulation/multipath.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cwm::perception {
namespace {

constexpr double kAlbedo = 0.5;    // a value between painted walls (0.8) and wood (0.3)
constexpr int kPatch_px = 16;      // 30 mm at one metre: corners are rounded over more than that
constexpr int kNode_px = 4;        // the bias is smooth: it is computed on this grid
constexpr int kReach_patches = 8;  // patches farther than a quarter of a metre add little

struct Spot {
  Vector3 p_C = Vector3::Zero();
  Vector3 normal_C = Vector3::Zero();
  double light = 0;    // light on it from the camera, relative to 1 m face on
  double area_m2 = 0;  // of the patch that it represents; 0 if nothing is seen

  bool seen() const { return area_m2 > 0; }
};

Spot SpotAt(const RangeImage& image, const PinholeCamera& camera, int u, int v) {
  const Sighting& pixel = image.at(u, v);
  if (!pixel.seen()) return {};
  Spot spot;
  spot.p_C = pixel.depth_m * RayDirection(camera, u, v);
  spot.normal_C = pixel.normal_C.cast<double>();
  const double range_m = spot.p_C.norm();
  constexpr double kGrazing = 0.1;  // cosine: beyond it hardly any light comes back
  const double cosine = std::max(kGrazing, -spot.normal_C.dot(spot.p_C) / range_m);
  spot.light = cosine / (range_m * range_m);
  const double side_m = kPatch_px * pixel.depth_m / camera.focal_px;
  spot.area_m2 = side_m * side_m / cosine;
  return spot;
}

struct PatchImage {
  int columns = 0;
  int rows = 0;
  std::vector<Spot> patches;
};

PatchImage Patches(const RangeImage& image, const PinholeCamera& camera) {
  PatchImage grid{
      .columns = image.width / kPatch_px, .rows = image.height / kPatch_px, .patches = {}};
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      grid.patches.push_back(SpotAt(image, camera, column * kPatch_px + kPatch_px / 2,
                                    row * kPatch_px + kPatch_px / 2));
    }
  }
  return grid;
}

// The contribution of a patch at a spot: its light as a share of the direct one, and the longer
// way.
struct Bounce {
  double share = 0;
  double excess_m = 0;  // of the range: half of the additional way
};

Bounce BounceOff(const Spot& patch, const Spot& spot) {
  const Vector3 to_patch = patch.p_C - spot.p_C;
  const double distance_m = to_patch.norm();
  const double facing = spot.normal_C.dot(to_patch) * -patch.normal_C.dot(to_patch);
  if (facing <= 0 || spot.normal_C.dot(to_patch) <= 0) return {};
  // The form factor of a small patch; at less than its own size it is no longer small.
  const double squared_m2 = std::max(distance_m * distance_m, patch.area_m2);
  const double form_factor =
      facing / (distance_m * distance_m) * patch.area_m2 / (std::numbers::pi * squared_m2);
  return {.share = kAlbedo * form_factor * patch.light / spot.light,
          .excess_m = 0.5 * (patch.p_C.norm() + distance_m - spot.p_C.norm())};
}

double BiasAt(const Spot& spot, int u, int v, const PatchImage& grid) {
  const int column = u / kPatch_px;
  const int row = v / kPatch_px;
  double light = 1;
  double weighted_m = 0;
  for (int r = std::max(0, row - kReach_patches);
       r <= std::min(grid.rows - 1, row + kReach_patches); ++r) {
    for (int c = std::max(0, column - kReach_patches);
         c <= std::min(grid.columns - 1, column + kReach_patches); ++c) {
      const Spot& patch = grid.patches[static_cast<std::size_t>(r) * grid.columns + c];
      if (!patch.seen()) continue;
      const Bounce bounce = BounceOff(patch, spot);
      light += bounce.share;
      weighted_m += bounce.share * bounce.excess_m;
    }
  }
  return weighted_m / light;
}

}  // namespace

std::vector<float> MultipathBias(const RangeImage& image, const PinholeCamera& camera) {
  const PatchImage grid = Patches(image, camera);
  std::vector<float> bias(image.pixels.size(), 0);
  for (int v = 0; v < image.height; v += kNode_px) {
    for (int u = 0; u < image.width; u += kNode_px) {
      const Spot spot = SpotAt(image, camera, u, v);
      if (!spot.seen()) continue;
      const auto bias_m = static_cast<float>(BiasAt(spot, u, v, grid));
      const std::int32_t object = image.at(u, v).object;
      for (int y = v; y < std::min(v + kNode_px, image.height); ++y) {
        for (int x = u; x < std::min(u + kNode_px, image.width); ++x) {
          if (image.at(x, y).object != object) continue;
          bias[static_cast<std::size_t>(y) * image.width + x] = bias_m;
        }
      }
    }
  }
  return bias;
}

}  // namespace cwm::perception
