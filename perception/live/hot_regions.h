// Connected parts of an image that differ from what is known, and for how long they have rested.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/live/depth_noise.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/pixel_rays.h"
#include "perception/live/pixel_rectangle.h"

namespace cwm::perception {

// Follows the hot blocks of one sensor. A block rests while nearly all of its pixels are as they
// were when its rest began, within noise: what creeps does not rest.
class HotRegions {
 public:
  HotRegions(const DepthCamera& camera, const DepthNoise& noise);

  // The regions of the next frame, the largest first. `body` names the expected body of each pixel.
  // A sensor that moves has no blocks that rest.
  std::vector<HotRegion> Find(const DepthImage& image, const FrameClasses& classes,
                              const std::vector<BodyId>& body, const PixelRays& rays, Stamp stamp,
                              bool is_still);

 private:
  struct Rest {
    bool was_hot = false;
    int frames = 0;
    Stamp since = {};
  };

  // The rest of the main share of the blocks: those at outlines flicker between two surfaces.
  Rest RestOf(const std::vector<std::int32_t>& blocks) const;
  void UpdateRest(const DepthImage& image, const FrameClasses& classes, Stamp stamp, bool is_still);
  PixelRectangle PixelsOf(std::int32_t block) const;
  HotRegion Describe(std::vector<std::int32_t> blocks, const DepthImage& image,
                     const FrameClasses& classes, const std::vector<BodyId>& body,
                     const PixelRays& rays, Stamp stamp) const;

  int width_;
  int height_;
  int columns_;
  int rows_;
  const DepthNoise& noise_;
  std::vector<Rest> rests_;            // per block
  std::vector<float> rested_depth_m_;  // of each hot block when its rest began
};

}  // namespace cwm::perception
