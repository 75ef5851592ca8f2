#include "perception/simulation/arrangement.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "perception/simulation/hull_distance.h"
#include "perception/simulation/range_image.h"

namespace cwm::perception {
namespace {

constexpr int kCoarsening = 4;  // one pixel of a coarse image represents 4 x 4
// In coarse pixels: 160 points of the full image, enough to show that something is there.
constexpr int kMinSeen = 10;
constexpr float kNothing_m = std::numeric_limits<float>::infinity();

PinholeCamera Coarse(const PinholeCamera& camera) {
  PinholeCamera coarse = camera;
  coarse.width /= kCoarsening;
  coarse.height /= kCoarsening;
  coarse.focal_px /= kCoarsening;
  coarse.center_x_px = (camera.center_x_px + 0.5) / kCoarsening - 0.5;
  coarse.center_y_px = (camera.center_y_px + 0.5) / kCoarsening - 0.5;
  return coarse;
}

std::vector<float> Depths(const RangeImage& image) {
  std::vector<float> depths;
  depths.reserve(image.pixels.size());
  for (const Sighting& pixel : image.pixels) {
    depths.push_back(pixel.seen() ? static_cast<float>(pixel.depth_m) : kNothing_m);
  }
  return depths;
}

void KeepNearest(const std::vector<float>& other, std::vector<float>& front) {
  for (std::size_t i = 0; i < front.size(); ++i) front[i] = std::min(front[i], other[i]);
}

struct SeenPixels {
  int alone = 0;
  int hidden = 0;

  double hidden_share() const { return alone == 0 ? 1 : static_cast<double>(hidden) / alone; }
};

SeenPixels Count(const std::vector<float>& silhouette, const std::vector<float>& front) {
  SeenPixels seen;
  for (std::size_t i = 0; i < front.size(); ++i) {
    if (silhouette[i] == kNothing_m) continue;
    ++seen.alone;
    seen.hidden += silhouette[i] > front[i];
  }
  return seen;
}

bool InImage(const Vector3& p_W, const PinholeCamera& camera) {
  const Vector3 p_C = camera.X_WC.inverse() * p_W;
  if (p_C.z() <= 0) return false;
  const double u = camera.center_x_px + camera.focal_px * p_C.x() / p_C.z();
  const double v = camera.center_y_px + camera.focal_px * p_C.y() / p_C.z();
  return u >= 0 && u < camera.width && v >= 0 && v < camera.height;
}

// True if the object is entirely above the support, which is level.
bool MayRestOn(const SimulatedObject& support, const SimulatedObject& object) {
  constexpr double kRounding_m = 1e-9;
  return support.is_support &&
         BoundsInWorld(object).min().z() >= BoundsInWorld(support).max().z() - kRounding_m;
}

}  // namespace

Arrangement::Arrangement(SimulatedScene furniture, const PinholeCamera& camera,
                         const ArrangementRules& rules)
    : scene_(std::move(furniture)),
      camera_(camera),
      coarse_camera_(Coarse(camera)),
      rules_(rules),
      furniture_count_(scene_.objects.size()),
      front_(Depths(Render(scene_, coarse_camera_))) {}

Arrangement::Silhouette Arrangement::SilhouetteOf(const SimulatedObject& object) const {
  return Depths(Render({.objects = {object}}, coarse_camera_));
}

bool Arrangement::KeepsApart(const SimulatedObject& candidate, Touching touching) const {
  for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
    const SimulatedObject& other = scene_.objects[i];
    if (MayRestOn(other, candidate)) continue;
    const double gap_m = Clearance_m(candidate, other);
    if (gap_m == 0 || (touching != i && gap_m < rules_.min_gap_m)) return false;
  }
  return true;
}

std::optional<std::vector<double>> Arrangement::HiddenSharesWith(const SimulatedObject& candidate,
                                                                 Touching touching) const {
  if (!InImage(BoundsInWorld(candidate).center(), camera_) || !KeepsApart(candidate, touching)) {
    return std::nullopt;
  }
  const Silhouette own = SilhouetteOf(candidate);
  Silhouette front = front_;
  KeepNearest(own, front);
  std::vector<double> shares;
  for (std::size_t i = 0; i <= silhouettes_.size(); ++i) {
    const SeenPixels seen = Count(i < silhouettes_.size() ? silhouettes_[i] : own, front);
    if (seen.alone - seen.hidden < kMinSeen || seen.hidden_share() > rules_.max_hidden) {
      return std::nullopt;
    }
    shares.push_back(seen.hidden_share());
  }
  return shares;
}

bool Arrangement::ShowsAll() const {
  return std::ranges::all_of(silhouettes_, [&](const Silhouette& silhouette) {
    const SeenPixels seen = Count(silhouette, front_);
    return seen.alone - seen.hidden >= kMinSeen && seen.hidden_share() <= rules_.max_hidden;
  });
}

void Arrangement::Add(SimulatedObject object) {
  silhouettes_.push_back(SilhouetteOf(object));
  KeepNearest(silhouettes_.back(), front_);
  scene_.objects.push_back(std::move(object));
}

}  // namespace cwm::perception
