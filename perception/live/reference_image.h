// The depth image that a sensor at rest measures of what is at rest.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/live/depth_noise.h"
#include "perception/live/frame_classes.h"
#include "perception/live/pixel_lanes.h"
#include "perception/live/pixel_rectangle.h"

namespace cwm::perception {

// Values by pixel while the gates of a span of a row are set. Used by one span after the other.
class RowScratch {
 public:
  // For spans of at most `width` pixels.
  explicit RowScratch(int width);

  // The depths `dv` rows below the span, from kBeside_px pixels before it to as many after it.
  std::vector<float>& Depths_m(int dv) {
    return depths_m_[static_cast<std::size_t>(dv) + kBeside_px];
  }
  DepthsAround around() const;

  std::vector<float> bends_m, max_bend_m, least_m, greatest_m;
  std::vector<std::uint8_t> is_set;

 private:
  std::array<std::vector<float>, 2 * kBeside_px + 1> depths_m_;
};

// Per pixel the slow mean of the measured depth, its spread in time, and how often there is a
// return. It contains the sensor's warp and whatever nobody modelled, so a frame is compared with
// it far more finely than with the expected view. The noise model is the prior of the spread, so a
// few frames are enough. Learns from what the caller tells to be at rest only.
class ReferenceImage {
 public:
  ReferenceImage(const DepthCamera& camera, const DepthNoise& noise);

  // chosen: a pixel has a reference after this many returns.
  static constexpr int kUsableFrames = 3;

  // Forgets everything: the sensor moved.
  void Forget();
  // True once frames enough have been learnt since everything was forgotten.
  bool usable() const { return first_frames_ >= kUsableFrames; }

  // A pixel with a reference is as it was if its depth is within [low_m, high_m]; beside an edge of
  // the reference that holds both its sides. In a hole, where neither a reference nor an expected
  // surface is, all is within that is not nearer than what is around the hole. Both gates are
  // infinite for the other pixels.
  const std::vector<float>& low_m() const { return low_m_; }
  const std::vector<float>& high_m() const { return high_m_; }
  const std::vector<float>& mean_m() const { return mean_m_; }
  bool Knows(std::size_t pixel) const { return frames_[pixel] >= kUsableFrames; }
  // True if the mean is as good as a third of one frame's noise.
  bool HasSettled(std::size_t pixel) const { return frames_[pixel] >= 3 * kUsableFrames; }
  // One standard deviation in time of the depth of a pixel that is known, metres.
  float Spread_m(std::size_t pixel) const;
  // The share of frames in which the pixel has a return.
  float Validity(std::size_t pixel) const { return validity_[pixel]; }

  struct Frame {
    std::span<const float> depth_m;
    const FrameClasses* classes = nullptr;  // kConsistent pixels outside of hot blocks are learnt
    std::span<const float> expected_m;      // of the known bodies; infinite for none
  };
  // Learns a frame. In the first frames, also pixels in which nothing is expected are learnt. At
  // first every pixel learns from every frame, later each row in its turn: the mean then follows
  // within some seconds at 30 Hz. A pixel that deviates in the same way for a second without making
  // its block hot is learnt anew.
  void Learn(const Frame& frame);

  // The known surface of a pixel was moved by this along the optical axis, its error stays.
  void Shift(std::size_t pixel, float by_m);
  // Forgets a pixel, or takes a depth as its reference. The caller refreshes the gates around it.
  void ForgetPixel(std::size_t pixel);
  void Take(std::size_t pixel, float depth_m);
  void RefreshGates(const PixelRectangle& pixels, std::span<const float> expected_m);

 private:
  void LearnRow(int v, const Frame& frame, bool is_first, bool all_pixels);
  void LearnPixel(int u, int v, const Frame& frame, bool is_first, bool is_turn, bool is_hot);
  void NoteDeviation(std::size_t pixel, float depth_m);
  ReferencePixels PixelsFrom(std::size_t first);
  void RefreshRow(int v, std::span<const float> expected_m, bool is_turn);
  enum class Refresh { kYoung, kAll, kAllAndEdges };
  void RefreshSpan(int v, int u_begin, int u_end, std::span<const float> expected_m, Refresh which);
  void FindDepthsAround(int v, int begin, int end);
  void SetGatesOfUnknown(int u, int v, float expected_m);
  float PriorVariance_m2(int u, int v) const;
  void RefreshHoles();
  std::size_t At(int u, int v) const { return static_cast<std::size_t>(v) * width_ + u; }

  int width_;
  int height_;
  const DepthNoise& noise_;
  std::vector<float> mean_m_, variance_m2_, validity_;
  std::vector<std::uint8_t> frames_;  // learnt, at most kMatureFrames
  std::vector<float> low_m_, high_m_;
  std::vector<std::uint8_t> is_edge_;
  std::vector<float> prior_m2_;  // of the noise model, when the gates were refreshed

  // A depth that deviates, and for how many turns of its row in succession.
  std::vector<float> deviation_m_;
  std::vector<std::uint8_t> deviation_turns_;

  int block_columns_;
  std::vector<float> hole_low_m_;  // per block
  RowScratch scratch_;
  int first_frames_ = 0;
  std::int64_t frame_ = 0;
  std::vector<std::int64_t> young_until_;  // per row: it learns in every frame before this one
};

}  // namespace cwm::perception
