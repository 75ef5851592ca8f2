// The rays of a scan that passed an object by, to what lies beside and behind it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "perception/fit/passing_rays.h"
#include "perception/hypotheses/object_hypothesis.h"
#include "perception/segmentation/segment_scene.h"

namespace cwm::perception {

// An even part of all rays, made once per scene; none of a scene without SegmentedScene::sight, which
// may have been seen from several places. The scene outlives it. Throws Stopped when `work` is stopped.
class SceneRays {
 public:
  SceneRays(const SegmentedScene& scene, const Work& work);

  // Those that run near the points of an object, or between them and what it stands on where that is
  // known (z = 0 of `X_LGround`, z up), and end on something else.
  PassingRays Past(const PointSet& points, const std::optional<Pose>& X_LGround,
                   const Work& work) const;

 private:
  struct Ray {
    std::uint32_t point = 0;  // that it ends at, into SegmentedScene::points
    Eigen::Vector3f direction = Eigen::Vector3f::Zero();  // unit, from the viewpoint
  };

  const SegmentedScene& scene_;
  std::size_t stride_ = 1;
  std::vector<Ray> rays_;
};

}  // namespace cwm::perception
