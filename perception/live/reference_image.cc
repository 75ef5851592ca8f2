#include "perception/live/reference_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "perception/live/pixel_lanes.h"

namespace cwm::perception {
namespace {

constexpr float kInfinite_m = std::numeric_limits<float>::infinity();
constexpr float kMinLow_m = 1e-6F;  // a gate never holds 0, which is no return

// chosen: the mean of this many frames has an error of a fifth of one frame's.
constexpr int kMatureFrames = 24;
// chosen: the rows learn in turn, with this gain: a time constant of 4 s at 30 Hz, within which
// warm-up drifts by less than the noise, and an error of the mean of a quarter of one frame's.
constexpr int kTurnFrames = 16;
constexpr float kMatureGain = 1.0F / 8;
constexpr float kMatureSpreadGain = 1.0F / 32;
constexpr float kValidityGain = 1.0F / 16;
// chosen: the noise model counts as many frames, and one part in five for ever, so that a spread
// that is small by chance makes no gate too narrow.
constexpr float kPriorFrames = 8;
constexpr float kPriorShare = 0.2F;
// chosen: a second at 30 Hz.
constexpr int kDeviationTurns = 2;
// chosen: turns of a row between two looks for edges, some two seconds at 30 Hz.
constexpr int kEdgeTurns = 4;
constexpr LearningGains kMature = {.mean = kMatureGain,
                                   .spread = kMatureSpreadGain,
                                   .validity = kValidityGain,
                                   .prior_share = kPriorShare,
                                   .gate_sigma = kDifference_sigma,
                                   .least_low_m = kMinLow_m};
// chosen: holes are compared with what is around them, which hardly changes.
constexpr int kHoleFrames = 64;

// chosen: a bend of the depth within two pixels that is no plane's: twice as much as surfaces of
// household goods have at one metre, and more than four errors of the mean.
constexpr int kEdgeRadius_px = 2;
constexpr float kMinBend_m = 0.01F;
constexpr float kBend_sigma = 4;

static_assert(kBlock_px == kPixelGroup);

// True if all bytes of a group of pixels are this one.
bool AllAre(const void* group, std::uint8_t byte) {
  std::array<std::uint8_t, kPixelGroup> all;
  all.fill(byte);
  return std::memcmp(group, all.data(), kPixelGroup) == 0;
}

bool AreConsistentOrMissing(const std::uint8_t* classes) {
  constexpr std::uint64_t kEach = 0x0101010101010101ULL;
  constexpr auto kConsistent = static_cast<std::uint64_t>(PixelClass::kConsistent);
  constexpr auto kMissing = static_cast<std::uint64_t>(PixelClass::kMissing);
  static_assert(kConsistent == 1 && kMissing == 4);
  std::uint64_t group = 0;
  std::memcpy(&group, classes, kPixelGroup);
  const std::uint64_t others = group & ~(kEach * (kConsistent | kMissing));
  const std::uint64_t both = group & (group >> 2) & kEach;  // of one pixel: another class
  return others == 0 && both == 0;
}

// Calls use(u, count) for each run of whole groups of a row for which `is_run` holds, and rest(u)
// for each of the other pixels. `is_run` takes the first pixel of a group.
template <class IsRun, class Use, class Rest>
void ByRuns(int width, const IsRun& is_run, const Use& use, const Rest& rest) {
  constexpr int kGroup = static_cast<int>(kPixelGroup);
  for (int u = 0; u < width;) {
    int end = u;
    while (end + kGroup <= width && is_run(end)) end += kGroup;
    if (end > u) use(u, static_cast<std::size_t>(end - u));
    u = end;
    for (const int after = std::min(width, end + kGroup); u < after; ++u) rest(u);
  }
}

}  // namespace

ReferenceImage::ReferenceImage(const DepthCamera& camera, const DepthNoise& noise)
    : width_(camera.width),
      height_(camera.height),
      noise_(noise),
      mean_m_(camera.pixel_count(), 0),
      variance_m2_(camera.pixel_count(), 0),
      validity_(camera.pixel_count(), 0),
      frames_(camera.pixel_count(), 0),
      low_m_(camera.pixel_count(), kInfinite_m),
      high_m_(low_m_),
      is_edge_(camera.pixel_count(), 0),
      prior_m2_(camera.pixel_count(), 0),
      deviation_m_(camera.pixel_count(), 0),
      deviation_turns_(camera.pixel_count(), 0),
      block_columns_((camera.width + kBlock_px - 1) / kBlock_px),
      hole_low_m_(
          static_cast<std::size_t>(block_columns_) * ((camera.height + kBlock_px - 1) / kBlock_px),
          kInfinite_m),
      young_until_(static_cast<std::size_t>(camera.height), kMatureFrames) {}

void ReferenceImage::Forget() {
  std::ranges::fill(frames_, 0);
  std::ranges::fill(validity_, 0);
  std::ranges::fill(low_m_, kInfinite_m);
  std::ranges::fill(high_m_, kInfinite_m);
  std::ranges::fill(deviation_turns_, 0);
  std::ranges::fill(hole_low_m_, kInfinite_m);
  first_frames_ = 0;
  std::ranges::fill(young_until_, frame_ + kMatureFrames);
}

float ReferenceImage::Spread_m(std::size_t pixel) const { return std::sqrt(variance_m2_[pixel]); }

void ReferenceImage::Learn(const Frame& frame) {
  const bool is_first = !usable();
  bool has_returns = false;
  for (int v = 0; v < height_; ++v) {
    const bool is_turn = (frame_ + v) % kTurnFrames == 0;
    if (is_turn || frame_ < young_until_[static_cast<std::size_t>(v)]) {
      LearnRow(v, frame, is_first, is_turn);
    }
  }
  if (is_first) {
    has_returns = std::ranges::any_of(frames_, [](std::uint8_t frames) { return frames > 0; });
    if (has_returns) ++first_frames_;
  }
  // The gates of a row depend on rows beside it, so all are learnt before.
  const bool renews_holes = (is_first && usable()) || frame_ % kHoleFrames == 0;
  if (renews_holes) RefreshHoles();
  for (int v = 0; v < height_; ++v) {
    const bool is_turn = (frame_ + v) % kTurnFrames == 0;
    if (!is_turn && frame_ >= young_until_[static_cast<std::size_t>(v)]) continue;
    RefreshRow(v, frame.expected_m, is_turn);
  }
  ++frame_;
}

// The pixels of a mature row that are at rest are learnt in groups, which saves most of the time.
void ReferenceImage::LearnRow(int v, const Frame& frame, bool is_first, bool all_pixels) {
  const std::uint8_t* const hot =
      frame.classes->hot_blocks.data() + static_cast<std::size_t>(v / kBlock_px) * block_columns_;
  const std::size_t row = At(0, v);
  const auto* const classes =
      reinterpret_cast<const std::uint8_t*>(frame.classes->pixels.data() + row);
  const std::uint8_t* const frames = frames_.data() + row;
  const auto learn = [&](int u) {
    if (!all_pixels && frames[u] >= kMatureFrames) return;
    LearnPixel(u, v, frame, is_first, all_pixels, hot[u / kBlock_px] != 0);
  };
  if (!all_pixels) {
    ByRuns(
        width_, [&](int u) { return AllAre(frames + u, kMatureFrames); }, [](int, std::size_t) {},
        learn);
    return;
  }
  const auto rests = [&](int u) {
    return hot[u / kBlock_px] == 0 && AllAre(frames + u, kMatureFrames) &&
           AllAre(deviation_turns_.data() + row + u, 0) && AreConsistentOrMissing(classes + u);
  };
  const auto learn_run = [&](int u, std::size_t count) {
    LearnDepths(frame.depth_m.data() + row + u, PixelsFrom(row + u), count, kMature);
  };
  ByRuns(width_, rests, learn_run, learn);
}

ReferencePixels ReferenceImage::PixelsFrom(std::size_t first) {
  return {.mean_m = mean_m_.data() + first,
          .variance_m2 = variance_m2_.data() + first,
          .validity = validity_.data() + first,
          .low_m = low_m_.data() + first,
          .high_m = high_m_.data() + first,
          .prior_m2 = prior_m2_.data() + first};
}

void ReferenceImage::LearnPixel(int u, int v, const Frame& frame, bool is_first, bool is_turn,
                                bool is_hot) {
  const std::size_t i = At(u, v);
  const float z = frame.depth_m[i];
  std::uint8_t& frames = frames_[i];
  const PixelClass pixel = frame.classes->pixels[i];
  if (pixel == PixelClass::kMissing) {
    validity_[i] -= validity_[i] * kValidityGain;
    return;
  }
  const bool is_unknown_at_first =
      is_first && pixel == PixelClass::kNearer && frame.expected_m[i] == kInfinite_m;
  if ((pixel != PixelClass::kConsistent || is_hot) && !is_unknown_at_first) {
    const bool deviates = pixel == PixelClass::kNearer || pixel == PixelClass::kFarther;
    if (is_turn && deviates && !is_hot) NoteDeviation(i, z);
    return;
  }
  if (is_turn) deviation_turns_[i] = 0;
  if (frames == 0) {
    validity_[i] = std::max(validity_[i], 0.5F);
    mean_m_[i] = z;
    frames = 1;
    return;
  }
  validity_[i] += (1 - validity_[i]) * kValidityGain;
  const float deviation = z - mean_m_[i];
  if (frames < kUsableFrames) {
    if (frames == 1) variance_m2_[i] = PriorVariance_m2(u, v);
    if (deviation * deviation > 2 * kDifference_sigma * kDifference_sigma * variance_m2_[i]) {
      mean_m_[i] = z;
      frames = 1;
      return;
    }
  } else if (z < low_m_[i] || z > high_m_[i]) {
    return;
  }
  const bool is_mature = frames >= kMatureFrames;
  if (!is_mature) ++frames;
  const float gain = is_mature ? kMatureGain : 1.0F / static_cast<float>(frames);
  const float spread_gain =
      is_mature ? kMatureSpreadGain : 1.0F / (kPriorFrames + static_cast<float>(frames));
  variance_m2_[i] += spread_gain * ((1 - gain) * deviation * deviation - variance_m2_[i]);
  mean_m_[i] += gain * deviation;
}

// Few pixels of a block that look different for good are no news.
void ReferenceImage::NoteDeviation(std::size_t pixel, float depth_m) {
  std::uint8_t& turns = deviation_turns_[pixel];
  const bool is_same = turns > 0 && std::abs(depth_m - deviation_m_[pixel]) <=
                                        kDifference_sigma * noise_.Axial_m(depth_m);
  if (!is_same) {
    deviation_m_[pixel] = depth_m;
    turns = 1;
  } else if (turns++ == kDeviationTurns) {
    Take(pixel, depth_m);
  }
}

void ReferenceImage::Shift(std::size_t pixel, float by_m) {
  mean_m_[pixel] += by_m;
  low_m_[pixel] += by_m;
  high_m_[pixel] += by_m;
}

void ReferenceImage::ForgetPixel(std::size_t pixel) {
  frames_[pixel] = 0;
  low_m_[pixel] = high_m_[pixel] = kInfinite_m;
  deviation_turns_[pixel] = 0;
  young_until_[pixel / static_cast<std::size_t>(width_)] = frame_ + kMatureFrames;
}

void ReferenceImage::Take(std::size_t pixel, float depth_m) {
  ForgetPixel(pixel);
  const auto width = static_cast<std::size_t>(width_);
  mean_m_[pixel] = depth_m;
  variance_m2_[pixel] =
      PriorVariance_m2(static_cast<int>(pixel % width), static_cast<int>(pixel / width));
  validity_[pixel] = std::max(validity_[pixel], 0.5F);
  frames_[pixel] = kUsableFrames;
}

// The noise of the depth, and of the place that the pixel shows on a slanted surface.
float ReferenceImage::PriorVariance_m2(int u, int v) const {
  const float center = mean_m_[At(u, v)];
  const float axial_m = noise_.Axial_m(center);
  const auto step = [&](int du, int dv) {
    if (u + du < 0 || u + du >= width_ || v + dv < 0 || v + dv >= height_) return 0.F;
    const std::size_t beside = At(u + du, v + dv);
    return frames_[beside] == 0 ? 0.F : std::abs(mean_m_[beside] - center);
  };
  // The lesser of both sides: the other one may be beyond an edge.
  const float slope_m =
      std::max(std::min(step(-1, 0), step(1, 0)), std::min(step(0, -1), step(0, 1)));
  const float lateral_m = slope_m * noise_.Lateral_px(center);
  return axial_m * axial_m + lateral_m * lateral_m;
}

void ReferenceImage::RefreshGates(const PixelRectangle& pixels, std::span<const float> expected_m) {
  for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
    for (int u = pixels.u_begin; u < pixels.u_end; ++u) {
      const std::size_t i = At(u, v);
      if (Knows(i)) is_edge_[i] = static_cast<std::uint8_t>(IsEdge(u, v));
      RefreshGate(u, v, expected_m[i]);
    }
  }
}

// After a frame was learnt: edges hardly change, so they are looked for again only now and then.
void ReferenceImage::RefreshRow(int v, std::span<const float> expected_m, bool is_turn) {
  const bool renews_edges = is_turn && frame_ / kTurnFrames % kEdgeTurns == 0;
  const std::size_t row = At(0, v);
  const std::uint8_t* const all_frames = frames_.data() + row;
  const auto refresh = [&](int u) {
    const int frames = all_frames[u];
    if (!is_turn && frames == kMatureFrames) return;
    const bool is_new = frames == kUsableFrames || frames == 2 * kUsableFrames;
    if (renews_edges || is_new) is_edge_[row + u] = static_cast<std::uint8_t>(IsEdge(u, v));
    RefreshGate(u, v, expected_m[row + u]);
  };
  if (renews_edges) {
    for (int u = 0; u < width_; ++u) refresh(u);
    return;
  }
  if (!is_turn) {
    ByRuns(
        width_, [&](int u) { return AllAre(all_frames + u, kMatureFrames); },
        [](int, std::size_t) {}, refresh);
    return;
  }
  const auto is_smooth = [&](int u) {
    return AllAre(all_frames + u, kMatureFrames) && AllAre(is_edge_.data() + row + u, 0);
  };
  const auto refresh_run = [&](int u, std::size_t count) {
    SetGates(PixelsFrom(row + u), count, kMature);
  };
  ByRuns(width_, is_smooth, refresh_run, refresh);
}

// The mean depth of a pixel; `otherwise_m` outside of the image and where nothing is known.
float ReferenceImage::MeanOr(int u, int v, float otherwise_m) const {
  if (u < 0 || u >= width_ || v < 0 || v >= height_) return otherwise_m;
  const std::size_t i = At(u, v);
  return frames_[i] == 0 ? otherwise_m : mean_m_[i];
}

// True if the depth about the pixel is not that of a plane, by its second differences.
bool ReferenceImage::IsEdge(int u, int v) const {
  const float center = mean_m_[At(u, v)];
  const float most = std::max(kMinBend_m, kBend_sigma * noise_.Axial_m(center));
  for (int step = 1; step <= kEdgeRadius_px; ++step) {
    for (const auto& [du, dv] : {std::pair(step, 0), {0, step}, {step, step}, {step, -step}}) {
      const float sides = MeanOr(u - du, v - dv, center) + MeanOr(u + du, v + dv, center);
      if (std::abs(sides - 2 * center) > most) return true;
    }
  }
  return false;
}

void ReferenceImage::RefreshGate(int u, int v, float expected_m) {
  const std::size_t i = At(u, v);
  if (!Knows(i)) {
    low_m_[i] = expected_m == kInfinite_m
                    ? hole_low_m_[static_cast<std::size_t>(v / kBlock_px) * block_columns_ +
                                  static_cast<std::size_t>(u / kBlock_px)]
                    : kInfinite_m;
    high_m_[i] = kInfinite_m;
    return;
  }
  const float center = mean_m_[i];
  float low = center;
  float high = center;
  if (is_edge_[i] != 0) {
    for (int dv = -kEdgeRadius_px; dv <= kEdgeRadius_px; ++dv) {
      for (int du = -kEdgeRadius_px; du <= kEdgeRadius_px; ++du) {
        const float beside = MeanOr(u + du, v + dv, center);
        low = std::min(low, beside);
        high = std::max(high, beside);
      }
    }
  }
  const float axial_m = noise_.Axial_m(center);
  prior_m2_[i] = axial_m * axial_m;
  const float variance = (1 - kPriorShare) * variance_m2_[i] + kPriorShare * prior_m2_[i];
  const float gain =
      frames_[i] >= kMatureFrames ? kMatureGain : 1.0F / static_cast<float>(frames_[i]);
  const float gate_m = kDifference_sigma * std::sqrt(variance * (1 + gain));
  low_m_[i] = std::max(low - gate_m, kMinLow_m);
  high_m_[i] = high + gate_m;
}

// The nearest known depth in and around each block; where there is none, that of the nearest blocks
// that have one.
void ReferenceImage::RefreshHoles() {
  const int rows = (height_ + kBlock_px - 1) / kBlock_px;
  std::vector<float> nearest_m(hole_low_m_.size(), kInfinite_m);
  for (int v = 0; v < height_; ++v) {
    float* const block =
        nearest_m.data() + static_cast<std::size_t>(v / kBlock_px) * block_columns_;
    for (int u = 0; u < width_; ++u) {
      if (Knows(At(u, v))) {
        block[u / kBlock_px] = std::min(block[u / kBlock_px], mean_m_[At(u, v)]);
      }
    }
  }
  const auto around = [&](int column, int row) {
    float least = kInfinite_m;
    for (int r = std::max(0, row - 1); r < std::min(rows, row + 2); ++r) {
      for (int c = std::max(0, column - 1); c < std::min(block_columns_, column + 2); ++c) {
        least = std::min(least, nearest_m[static_cast<std::size_t>(r) * block_columns_ + c]);
      }
    }
    return least;
  };
  // One ring of blocks at a time.
  for (bool has_changed = true; has_changed;) {
    has_changed = false;
    std::vector<float> filled_m = nearest_m;
    std::size_t i = 0;
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < block_columns_; ++column, ++i) {
        if (nearest_m[i] != kInfinite_m) continue;
        filled_m[i] = around(column, row);
        has_changed |= filled_m[i] != kInfinite_m;
      }
    }
    nearest_m.swap(filled_m);
  }
  std::size_t i = 0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < block_columns_; ++column, ++i) {
      const float least = around(column, row);
      hole_low_m_[i] = least == kInfinite_m
                           ? kInfinite_m
                           : std::max(least - noise_.Explained_m(least), kMinLow_m);
    }
  }
}

}  // namespace cwm::perception
