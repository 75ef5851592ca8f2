// Tells whether a camera that did not move still sees the same, from one frame then and one now.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "perception/live/depth_image.h"
#include "perception/live/depth_noise.h"

namespace cwm::perception {

// One frame of a camera at rest, with which single later frames are compared. A ReferenceImage
// learns from several frames how much each pixel spreads in time; here both frames have the noise
// of the model. The sensor's warp is the same in both, so that it cancels.
class StillView {
 public:
  // `image` has the camera's size.
  StillView(const DepthCamera& camera, const SensorNoise& noise,
            std::shared_ptr<const DepthImage> image);

  const DepthCamera& camera() const { return camera_; }
  // The size of all that is kept for each pixel.
  std::size_t bytes() const { return 2 * sizeof(float) * camera_.pixel_count(); }

  // Empty if the frame differs, or may differ, from the image by more than noise. Otherwise, per
  // pixel of the frame, the pixel of the image that shows the same surface: mostly the same one,
  // beside edges and for new returns a near one; -1 for pixels without a return, and for those
  // whose surface the image does not show nearby. A frame differs if in a window of 8 x 8 pixels
  //   24 pixels are nearer, or farther, by 5 standard deviations; beside an edge both its sides and
  //   all between are equal,
  //   half of the pixels are returns of a surface that the image does not show within 4 pixels,
  //   or the mean depth differs by 5 standard deviations, as also in a patch of 32 x 32.
  // Returns that are lost are no evidence of anything.
  // Precondition: the frame has the camera's size.
  std::optional<std::vector<std::int32_t>> Match(const DepthImage& now) const;

 private:
  DepthCamera camera_;
  DepthNoise noise_;
  std::shared_ptr<const DepthImage> image_;
  std::vector<float> variance_m2_;  // by pixel, of a depth of one frame
};

}  // namespace cwm::perception
