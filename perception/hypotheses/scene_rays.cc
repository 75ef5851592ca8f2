#include "perception/hypotheses/scene_rays.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "perception/modeler/object_modeler.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

// chosen: the margin around the object's points and their feet in the view: as much as a solid may
// extend beyond its visible part, and twelve pixels of a Kinect.
constexpr float kBesideShare = 0.15f;
constexpr float kBeside_rad = 0.02f;

// The view of an object: where rays cross the plane at distance 1 that is normal to its middle ray.
struct View {
  Eigen::Matrix3f across = Eigen::Matrix3f::Identity();
  Eigen::AlignedBox2f around;    // of the points
  Eigen::AlignedBox2f standing;  // of the points and their feet

  Eigen::Vector3f middle() const { return across.col(2); }
  // The cosine to the middle ray that all rays in `standing` reach: one product rejects most rays.
  float MinCosine() const {
    if (standing.isEmpty()) return 2;
    const Eigen::Vector2f farthest = standing.min().cwiseAbs().cwiseMax(standing.max().cwiseAbs());
    // derived: somewhat more than the rounding error of the product of two unit vectors.
    constexpr float kRounding = std::numeric_limits<float>::epsilon() * 64;
    return 1 / std::sqrt(1 + farthest.squaredNorm()) - kRounding;
  }
  // Empty for rays that point behind the viewer.
  std::optional<Eigen::Vector2f> At(const Eigen::Vector3f& ray) const {
    const Eigen::Vector3f x = across.transpose() * ray;
    if (!(x.z() > 0)) return std::nullopt;
    return Eigen::Vector2f(x.head<2>() / x.z());
  }
};

void Widen(Eigen::AlignedBox2f& box) {
  if (box.isEmpty()) return;
  const Eigen::Vector2f beside =
      kBesideShare * box.sizes() + Eigen::Vector2f::Constant(kBeside_rad);
  box.min() -= beside;
  box.max() += beside;
}

// Projects a point to the ground.
class Feet {
 public:
  explicit Feet(const Pose& X_LSupport)
      : up_(X_LSupport.linear().col(2).cast<float>()),
        offset_m_(up_.dot(X_LSupport.translation().cast<float>())) {}
  Eigen::Vector3f operator()(const Eigen::Vector3f& p) const {
    return p - (up_.dot(p) - offset_m_) * up_;
  }

 private:
  Eigen::Vector3f up_;
  float offset_m_;
};

View ViewOf(const OrientedPoints& all, const PointSet& members,
            const std::optional<Pose>& X_LGround, const Work& work) {
  PollEvery poll(work, ItemsPerChunk(20ns));
  const Eigen::Vector3f viewpoint = all.viewpoint.cast<float>();
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  for (std::uint32_t i : members) middle += all.points[i] - viewpoint;
  View view;
  if (!(middle.norm() > 0)) return view;
  view.across = BasisFromZ(middle.normalized().cast<double>()).cast<float>();
  std::optional<Feet> feet;
  if (X_LGround) feet.emplace(*X_LGround);
  for (std::uint32_t i : members) {
    poll();
    const Eigen::Vector3f& p = all.points[i];
    if (const auto at = view.At(p - viewpoint)) view.around.extend(*at);
    if (!feet) continue;
    if (const auto at = view.At((*feet)(p)-viewpoint)) view.standing.extend(*at);
  }
  view.standing.extend(view.around);
  Widen(view.around);
  Widen(view.standing);
  return view;
}

}  // namespace

SceneRays::SceneRays(const SegmentedScene& scene, const Work& work) : scene_(scene) {
  if (!scene.sight) return;
  PollEvery poll(work, ItemsPerChunk(20ns));
  const std::size_t count = scene.points.size();
  // derived: an object of 2 000 of a camera's 300 000 pixels has about 300 of these rays around it,
  // and the search through all of them takes 0.1 ms per object.
  stride_ = std::max<std::size_t>(1, count / kMaxScenePoints);
  const Eigen::Vector3f viewpoint = scene.points.viewpoint.cast<float>();
  for (std::size_t i = 0; i < count; i += stride_) {
    poll();
    rays_.push_back({.point = static_cast<std::uint32_t>(i),
                     .direction = (scene.points.points[i] - viewpoint).normalized()});
  }
}

PassingRays SceneRays::PassingRaysOf(const PointSet& points, const std::optional<Pose>& X_LGround,
                                     const Work& work) const {
  if (rays_.empty()) return {};
  const View view = ViewOf(scene_.points, points, X_LGround, work);
  std::vector<char> ends_on_it(rays_.size(), 0);
  for (std::uint32_t i : points) {
    if (i % stride_ == 0) ends_on_it[i / stride_] = 1;
  }
  PassingRays out;
  out.weight = static_cast<double>(stride_);
  std::vector<std::uint32_t> below;
  const float min_cos = view.MinCosine();
  const auto add = [&](std::uint32_t point) {
    out.ends.push_back(scene_.points.points[point]);
    out.sigma_m.push_back(scene_.points.sigma_m[point]);
  };
  for (std::size_t k = 0; k < rays_.size(); ++k) {
    const Ray& ray = rays_[k];
    if (ends_on_it[k]) continue;
    if (ray.direction.dot(view.middle()) < min_cos) continue;
    const std::optional<Eigen::Vector2f> at = view.At(ray.direction);
    if (!at || !view.standing.contains(*at)) continue;
    if (view.around.contains(*at)) {
      add(ray.point);
    } else {
      below.push_back(ray.point);
    }
  }
  out.around_count = out.ends.size();
  for (std::uint32_t point : below) add(point);
  return out;
}

}  // namespace cwm::perception
