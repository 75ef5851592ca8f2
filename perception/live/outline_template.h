// How the outline of a body before what is behind it has moved, by the depths of a frame.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <vector>

#include "perception/live/depth_noise.h"
#include "perception/live/expected_view.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/pixel_rays.h"
#include "perception/live/reference_image.h"
#include "perception/live/usual_value.h"

namespace cwm::perception {

// Measures by how many pixels the outline of a body, its occluding contour, has moved, as a rigid
// motion of the body. The depths of its surface say nothing of a motion along the surface, such as
// that of a box along its visible faces; the outline does.
//
// The outline is measured along rows or columns of pixels that cross it, by how many of their
// pixels show the body. Most sensors have no returns in some pixels between the body and what is
// behind it; half of those count as the body's. A point p_C of the outline, whose image moves along the outward normal n of
// the outline by n * (J w) when the point moves by w, J being the derivative of the projection,
// changes this number by n * (J w) / |n_a|, with a the axis of the crossing. Each crossing learns
// its usual number: the slow mean of depths that flicker between two surfaces errs by too much.
class OutlineTemplate {
 public:
  // chosen: some are lost to missing returns; 100 determine a shift to a tenth of a pixel.
  static constexpr int kMaxCrossings = 100;

  // Selects crossings evenly along the outline of the body among those at which the reference has
  // settled and drops from the body to something that is clearly behind it. Those that were
  // selected before keep what they have learnt, unless the body was given another pose.
  void Build(const KnownBody& body, bool has_moved, const ExpectedView& view,
             const DepthCamera& camera, const PixelRays& rays, const Pose& X_WC,
             const ReferenceImage& reference, const DepthNoise& noise);

  // Adds the evidence of one frame: of crossings that have learnt enough, and both ends of which
  // are as they were. Learns the frame.
  void Measure(const DepthImage& image, const FrameClasses& classes,
               const ReferenceImage& reference, BodyEvidence& evidence);

 private:
  // A pixel of the body beside one that is not, `step` pixels of the image further.
  struct Border {
    std::int32_t pixel = 0;
    std::int32_t step = 0;
    friend auto operator<=>(const Border&, const Border&) = default;
  };
  struct Crossing {
    Border border = {};
    std::array<float, 6> derivative = {};  // of the number of pixels by the twist
    float weight = 0;
    float sigma_px = 0;
    std::int32_t pixel = 0;    // the first, on the body; the others are border.step apart
    std::int32_t count = 0;    // of pixels
    float nearest_m = 0;       // a depth before this is of something else
    float near_m = 0;          // up to this depth a pixel shows the body, ...
    float far_m = 0;           // ... and from this one what is behind it; between, both
    float far_within_m = 0;    // the noise of the last one
    UsualValue usual_px = {};  // the number of pixels that show the body
  };

  static float PixelsOfBody(const Crossing& crossing, const DepthImage& image,
                            const FrameClasses& classes, const ReferenceImage& reference);
  static std::vector<Border> BordersOf(BodyId id, const ExpectedView& view,
                                       const DepthCamera& camera);
  static bool FindDrop(const Border& border, const ExpectedView& view,
                       const ReferenceImage& reference, const DepthNoise& noise,
                       Crossing& crossing);

  std::vector<Crossing> crossings_;  // by ascending border
};

}  // namespace cwm::perception
