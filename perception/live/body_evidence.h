// The evidence of a frame about each known body in it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/live/compare_frame.h"
#include "perception/live/expected_view.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/pixel_rays.h"
#include "perception/live/reference_image.h"
#include "perception/live/usual_value.h"

namespace cwm::perception {

// Measures how the depths of a body's pixels differ from their usual ones, as a rigid motion. The
// pixels and their derivatives are kept while body, view and reference stay, so that a frame costs
// six multiply-adds per pixel, of which no body has more than kMaxMotionPixels. A pixel that shows
// the body anew, since something before it left, says nothing before it has learnt its usual depth.
//
// A surface point q, relative to the body's origin, with normal n that moves by v + w x q changes
// the depth along the ray d, of depth 1, by n * (v + w x q) / (n * d).
class MotionTemplate {
 public:
  // chosen: noise is correlated over some pixels, so pixels farther apart than that hold nearly all
  // of the information of an object's surface.
  static constexpr int kMaxMotionPixels = 400;

  // Selects pixels evenly among those of the body that have a reference, away from its edges and
  // not seen at a grazing angle. The body is seen in `pixels` pixels. Those that were selected
  // before keep what they have learnt, unless the body was given another pose.
  void Build(const KnownBody& body, int pixels, bool has_moved, const ExpectedView& view,
             const DepthCamera& camera, const PixelRays& rays, const Pose& X_WC,
             const ReferenceImage& reference);

  // Adds the evidence of one frame: of pixels that differ by at most kExplainedWithin_m. What is
  // farther before or behind the body says nothing about its motion. Learns the frame.
  void Measure(const DepthImage& image, const FrameClasses& classes, BodyEvidence& evidence);

 private:
  struct Sample {
    std::array<float, 6> derivative = {};  // of the depth by the twist
    float weight = 0;
    std::int32_t pixel = 0;
    UsualValue depth_m = {};
  };

  int stride_ = 0;
  std::vector<Sample> samples_;            // by ascending pixel
  Matrix6 information_ = Matrix6::Zero();  // of all samples
};

// The plane n * p = 1, in the optical frame, of the expected surface about a pixel. False at edges
// and at a grazing incidence.
bool ExpectedPlaneAt(const ExpectedView& view, const DepthCamera& camera, int u, int v,
                     Eigen::Vector3f& plane_C);

// Fills `is_hot` for every body of the evidence that has pixels in hot blocks or within
// kBesideOutline_px of one.
inline constexpr int kBesideOutline_px = 4;
void MarkHotBodies(const FrameClasses& classes, const std::vector<BodyId>& body,
                   std::span<BodyEvidence> evidence);

// Fills `shown`, `passed` and `beyond` of a body.
void CountPassed(const ExpectedView& view, const DepthImage& image, const FrameClasses& classes,
                 const ReferenceImage& reference, const DepthNoise& noise, BodyEvidence& evidence);

// The points that may be of a body, which is seen in `seen_pixels` pixels: see
// BodyEvidence::points_L.
std::vector<Eigen::Vector3f> PointsOfBody(BodyId id, int seen_pixels, const ExpectedView& view,
                                          const DepthImage& image, const DepthCamera& camera,
                                          const FrameClasses& classes, const PixelRays& rays);

}  // namespace cwm::perception
