#include "server/core/kept_views.h"

#include <algorithm>
#include <utility>

#include "server/core/approximate_bytes.h"

namespace cwm::server {
namespace {

// The bindings name every member, so that one that is added cannot be forgotten here.
auto ValuesOf(const perception::SensorNoise& noise) {
  const auto& [model, sigma, quadratic, image_width, registration] = noise;
  return std::tuple(model, sigma, quadratic, image_width, registration);
}

auto ValuesOf(const perception::ModelerOptions& options) {
  const auto& [planes, cylinders, spheres, cones, split, from_viewpoint, reduced, max_radius,
               min_radius, min_inliers, missed, seed] = options;
  return std::tuple(planes, cylinders, spheres, cones, split, from_viewpoint, reduced, max_radius,
                    min_radius, min_inliers, missed, seed);
}

auto ValuesOf(const perception::SurfaceOptions& options) {
  const auto& [spacing, max_triangles] = options;
  return std::tuple(spacing, max_triangles);
}

// All but the pose, which is a condition of its own, and what concerns threads, on which nothing
// depends.
bool SameOptions(const perception::InterpretOptions& a, const perception::InterpretOptions& b) {
  return ValuesOf(a.noise) == ValuesOf(b.noise) && a.up_C == b.up_C &&
         a.clustering == b.clustering && ValuesOf(a.modeler) == ValuesOf(b.modeler) &&
         a.disabled_passes == b.disabled_passes && ValuesOf(a.surface) == ValuesOf(b.surface);
}

}  // namespace

bool operator==(const ViewConditions& a, const ViewConditions& b) {
  return a.pose.X_WC.matrix() == b.pose.X_WC.matrix() && a.pose.given == b.pose.given &&
         a.in_world_frame == b.in_world_frame && a.mode == b.mode &&
         a.viewpoint_C == b.viewpoint_C && SameOptions(a.options, b.options) &&
         a.width == b.width && a.height == b.height && a.seen_from_origin == b.seen_from_origin;
}

std::int64_t KeptView::bytes() const {
  // chosen: names, warnings and the noise of the sensor by depth.
  constexpr std::int64_t kOthers = 64 << 10;
  std::int64_t sum = kOthers + static_cast<std::int64_t>(labels.size() * sizeof(std::uint32_t));
  sum += static_cast<std::int64_t>((points.size() + normals.size()) * sizeof(Eigen::Vector3f));
  if (image) sum += static_cast<std::int64_t>(image->bytes());
  for (const collision::WorldObjectPtr& object : provisional) {
    if (object != nullptr) sum += ApproximateBytes(*object);
  }
  return sum;
}

void KeptViews::Keep(KeptViewPtr view) {
  std::list<KeptViewPtr> dropped;  // freed after the lock
  const std::lock_guard lock(mutex_);
  const auto replaced = std::ranges::find_if(
      views_, [&](const KeptViewPtr& each) { return each->sensor == view->sensor; });
  if (replaced != views_.end()) dropped.splice(dropped.end(), views_, replaced);
  views_.push_front(std::move(view));
  if (views_.size() > kMaxViews) {
    dropped.splice(dropped.end(), views_, std::prev(views_.end()));
  }
  std::int64_t bytes = 0;
  for (const KeptViewPtr& each : views_) bytes += each->bytes();
  if (charge_.Resize(bytes).ok()) return;
  dropped.splice(dropped.end(), views_, views_.begin());
  bytes -= dropped.back()->bytes();
  charge_.ForceResize(bytes);
}

KeptViewPtr KeptViews::Find(const std::string& sensor) {
  const std::lock_guard lock(mutex_);
  const auto found =
      std::ranges::find_if(views_, [&](const KeptViewPtr& each) { return each->sensor == sensor; });
  if (found == views_.end()) return nullptr;
  views_.splice(views_.begin(), views_, found);
  return *found;
}

void KeptViews::Clear() {
  std::list<KeptViewPtr> dropped;
  const std::lock_guard lock(mutex_);
  dropped.swap(views_);
  charge_.ForceResize(0);
}

}  // namespace cwm::server
