// Connected parts of an image that differ from what is known, and for how long they have rested.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/live/depth_noise.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/past_views.h"
#include "perception/live/pixel_rays.h"
#include "perception/live/pixel_rectangle.h"
#include "perception/live/reference_image.h"
#include "perception/live/surface_age.h"

namespace cwm::perception {

// Follows the hot blocks of one sensor. A block rests while nearly all of its pixels are as they
// were when its rest began, within noise: what creeps does not rest.
class HotRegions {
 public:
  HotRegions(const DepthCamera& camera, const DepthNoise& noise);

  // The regions of the next frame, the largest first. `body` names the expected body of each pixel.
  // `moving`: only for a sensor that moves, the blocks of which rest if what they show does, in the
  // world.
  struct MovingSensor {
    Pose X_WC = Pose::Identity();
    PoseSigma sigma = {};
    const PastViews* past = nullptr;
  };
  struct View {
    const DepthImage& image;
    const FrameClasses& classes;
    const std::vector<BodyId>& body;
    const PixelRays& rays;
    const ReferenceImage& reference;  // knows nothing while the sensor moves
  };
  std::vector<HotRegion> Find(const View& view, Stamp stamp, bool is_still,
                              const MovingSensor* moving = nullptr);

 private:
  struct Rest {
    bool was_hot = false;
    int frames = 0;
    Stamp since = {};
  };

  // The rest of this share of the blocks: those at outlines flicker between two surfaces.
  Rest RestOf(const std::vector<std::int32_t>& blocks, double share) const;
  void UpdateRest(const DepthImage& image, const FrameClasses& classes, Stamp stamp, bool is_still);
  void UpdateRestInWorld(const DepthImage& image, const FrameClasses& classes,
                         const PixelRays& rays, Stamp stamp, const Vector3& origin_W);
  // Drops the points of a block at places that no earlier frame saw through.
  static void KeepEntered(const MovingSensor& moving, std::size_t first,
                          std::vector<Eigen::Vector3f>& points_L);
  HotRegion Describe(std::vector<std::int32_t> blocks, const View& view, Stamp stamp,
                     const MovingSensor* moving) const;

  int width_;
  int height_;
  int columns_;
  int rows_;
  const DepthNoise& noise_;
  std::vector<Rest> rests_;            // per block
  std::vector<float> rested_depth_m_;  // of each hot block when its rest began
  SurfaceAge age_;                     // of what a moving sensor sees
};

}  // namespace cwm::perception
