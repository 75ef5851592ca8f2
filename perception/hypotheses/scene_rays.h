// The rays of a scan that passed an object and ended beside or behind it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "perception/fit/passing_rays.h"
#include "perception/hypotheses/object_hypothesis.h"
#include "perception/segmentation/segment_scene.h"

namespace cwm::perception {

// An even sample of all rays, made once per scene. Empty for a scene without SegmentedScene::sight,
// which may have been seen from several places. The scene must outlive it. Throws Stopped when
// `work` is stopped.
class SceneRays {
 public:
  SceneRays(const SegmentedScene& scene, const Work& work);

  // Returns the rays near the points of an object, or between them and its ground if that is known
  // (z = 0 of `X_LGround`, z up), that end on something else.
  PassingRays PassingRaysOf(const PointSet& points, const std::optional<Pose>& X_LGround,
                            const Work& work) const;

 private:
  struct Ray {
    std::uint32_t point = 0;  // where the ray ends, index into SegmentedScene::points
    Eigen::Vector3f direction = Eigen::Vector3f::Zero();  // unit, from the viewpoint
  };

  const SegmentedScene& scene_;
  std::size_t stride_ = 1;
  std::vector<Ray> rays_;
};

}  // namespace cwm::perception
