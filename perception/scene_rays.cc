#include "perception/scene_rays.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace cwm::perception {
namespace {

// Of all: a thing of 2 000 of a camera's 300 000 pixels has some 300 of these about it, and to look
// at all of them for each thing takes 0.1 ms.
constexpr std::size_t kMostRays = 40'000;
// Around what the thing's points fill of the view: as much as a solid may reach beyond what is seen
// of it, and twelve pixels of a Kinect.
constexpr float kBesideShare = 0.15f;
constexpr float kBeside_rad = 0.02f;
constexpr int kPointsPerPiece = 1 << 14;  // of some nanoseconds

// Where rays cross the plane at distance 1 that is normal to the middle one of a thing's.
struct View {
  Eigen::Matrix3f across = Eigen::Matrix3f::Identity();
  Eigen::AlignedBox2f bounds;

  bool Holds(const Eigen::Vector3f& ray) const {
    const Eigen::Vector3f x = across.transpose() * ray;
    return x.z() > 0 && bounds.contains(Eigen::Vector2f(x.head<2>() / x.z()));
  }
};

View ViewOf(const SegmentedScene& scene, const SegmentedThing& thing, const Work& work) {
  PollEvery poll(work, kPointsPerPiece);
  const Eigen::Vector3f viewpoint = scene.points.viewpoint.cast<float>();
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  for (std::uint32_t i : thing.points) middle += scene.points.points[i] - viewpoint;
  View view;
  if (!(middle.norm() > 0)) return view;
  view.across = BasisFromZ(middle.normalized().cast<double>()).cast<float>();
  for (std::uint32_t i : thing.points) {
    poll();
    const Eigen::Vector3f x = view.across.transpose() * (scene.points.points[i] - viewpoint);
    if (x.z() > 0) view.bounds.extend(Eigen::Vector2f(x.head<2>() / x.z()));
  }
  if (view.bounds.isEmpty()) return view;
  const Eigen::Vector2f beside =
      kBesideShare * view.bounds.sizes() + Eigen::Vector2f::Constant(kBeside_rad);
  view.bounds.min() -= beside;
  view.bounds.max() += beside;
  return view;
}

}  // namespace

SceneRays::SceneRays(const SegmentedScene& scene, const Work& work) : scene_(scene) {
  if (!scene.sight) return;
  PollEvery poll(work, kPointsPerPiece);
  const std::size_t count = scene.points.size();
  stride_ = std::max<std::size_t>(1, count / kMostRays);
  const Eigen::Vector3f viewpoint = scene.points.viewpoint.cast<float>();
  for (std::size_t i = 0; i < count; i += stride_) {
    rays_.push_back({.point = static_cast<std::uint32_t>(i),
                     .from_viewpoint = scene.points.points[i] - viewpoint});
  }
  for (std::size_t t = 0; t < scene.things.size(); ++t) {
    for (std::uint32_t i : scene.things[t].points) {
      poll();
      if (i % stride_ == 0) rays_[i / stride_].thing = static_cast<std::int32_t>(t);
    }
  }
}

PassingRays SceneRays::Past(std::size_t thing, const Work& work) const {
  const View view = ViewOf(scene_, scene_.things[thing], work);
  PassingRays out;
  out.weight = static_cast<double>(stride_);
  for (const Ray& ray : rays_) {
    if (ray.thing == static_cast<std::int32_t>(thing) || !view.Holds(ray.from_viewpoint)) continue;
    out.ends.push_back(scene_.points.points[ray.point]);
    out.sigma_m.push_back(scene_.points.sigma_m[ray.point]);
  }
  return out;
}

}  // namespace cwm::perception
