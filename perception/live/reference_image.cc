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

// Calls use(u, count) for each run of whole groups of a row for which `is_run` holds, and
// rest(u, count) for all between. `is_run` takes the first pixel of a group.
template <class IsRun, class Use, class Rest>
void ByRuns(int width, const IsRun& is_run, const Use& use, const Rest& rest) {
  constexpr int kGroup = static_cast<int>(kPixelGroup);
  const auto is_run_at = [&](int u) { return u + kGroup <= width && is_run(u); };
  for (int u = 0; u < width;) {
    int end = u;
    while (is_run_at(end)) end += kGroup;
    if (end > u) use(u, end - u);
    u = end;
    while (end < width && !is_run_at(end)) end += kGroup;
    end = std::min(end, width);
    if (end > u) rest(u, end - u);
    u = end;
  }
}

// True in the frames after which a pixel's edges are looked for: when it is first known, and once
// more when it is known better.
bool IsFirstKnown(int frames) {
  constexpr int kUsableFrames = ReferenceImage::kUsableFrames;
  return frames == kUsableFrames || frames == 2 * kUsableFrames;
}

}  // namespace

RowScratch::RowScratch(int width) {
  const std::size_t count = (static_cast<std::size_t>(width) / kPixelGroup + 1) * kPixelGroup;
  for (std::vector<float>& row : depths_m_) row.resize(count + 2 * kBeside_px);
  for (std::vector<float>* const values : {&bends_m, &max_bend_m, &least_m, &greatest_m}) {
    values->resize(count);
  }
  is_set.resize(count);
}

DepthsAround RowScratch::around() const {
  DepthsAround rows = {};
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = depths_m_[k].data() + kBeside_px;
  return rows;
}

// One group more than the image has: the last row's last group may end beyond it.
ReferenceImage::ReferenceImage(const DepthCamera& camera, const DepthNoise& noise)
    : width_(camera.width),
      height_(camera.height),
      noise_(noise),
      mean_m_(camera.pixel_count() + kPixelGroup, 0),
      variance_m2_(camera.pixel_count() + kPixelGroup, 0),
      validity_(camera.pixel_count() + kPixelGroup, 0),
      frames_(camera.pixel_count() + kPixelGroup, 0),
      low_m_(camera.pixel_count() + kPixelGroup, kInfinite_m),
      high_m_(low_m_),
      is_edge_(camera.pixel_count() + kPixelGroup, 0),
      prior_m2_(camera.pixel_count() + kPixelGroup, 0),
      deviation_m_(camera.pixel_count() + kPixelGroup, 0),
      deviation_turns_(camera.pixel_count() + kPixelGroup, 0),
      block_columns_((camera.width + kBlock_px - 1) / kBlock_px),
      hole_low_m_(
          static_cast<std::size_t>(block_columns_) * ((camera.height + kBlock_px - 1) / kBlock_px),
          kInfinite_m),
      scratch_(camera.width),
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
  const auto learn = [&](int u_begin, int count) {
    for (int u = u_begin; u < u_begin + count; ++u) {
      if (!all_pixels && frames[u] >= kMatureFrames) continue;
      LearnPixel(u, v, frame, is_first, all_pixels, hot[u / kBlock_px] != 0);
    }
  };
  if (!all_pixels) {
    ByRuns(
        width_, [&](int u) { return AllAre(frames + u, kMatureFrames); }, [](int, int) {}, learn);
    return;
  }
  const auto rests = [&](int u) {
    return hot[u / kBlock_px] == 0 && AllAre(frames + u, kMatureFrames) &&
           AllAre(deviation_turns_.data() + row + u, 0) && AreConsistentOrMissing(classes + u);
  };
  const auto learn_run = [&](int u, int count) {
    LearnDepths(frame.depth_m.data() + row + u, PixelsFrom(row + u),
                static_cast<std::size_t>(count), kMature);
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
    RefreshSpan(v, pixels.u_begin, pixels.u_end, expected_m, Refresh::kAllAndEdges);
  }
}

// After a frame was learnt: edges hardly change, so they are looked for again only now and then.
void ReferenceImage::RefreshRow(int v, std::span<const float> expected_m, bool is_turn) {
  const std::uint8_t* const frames = frames_.data() + At(0, v);
  if (is_turn && frame_ / kTurnFrames % kEdgeTurns == 0) {
    RefreshSpan(v, 0, width_, expected_m, Refresh::kAllAndEdges);
    return;
  }
  const Refresh which = is_turn ? Refresh::kAll : Refresh::kYoung;
  const auto refresh = [&](int u, int count) { RefreshSpan(v, u, u + count, expected_m, which); };
  if (!is_turn) {
    ByRuns(
        width_, [&](int u) { return AllAre(frames + u, kMatureFrames); }, [](int, int) {}, refresh);
    return;
  }
  const auto is_smooth = [&](int u) {
    return AllAre(frames + u, kMatureFrames) && AllAre(is_edge_.data() + At(u, v), 0);
  };
  const auto refresh_run = [&](int u, int count) {
    SetGates(PixelsFrom(At(u, v)), static_cast<std::size_t>(count), kMature);
  };
  ByRuns(width_, is_smooth, refresh_run, refresh);
}

// Whole groups of pixels at a time; those beside the span stay as they are.
void ReferenceImage::RefreshSpan(int v, int u_begin, int u_end, std::span<const float> expected_m,
                                 Refresh which) {
  constexpr int kGroup = static_cast<int>(kPixelGroup);
  const int begin = u_begin / kGroup * kGroup;
  const int end = (u_end + kGroup - 1) / kGroup * kGroup;
  const std::size_t first = At(begin, v);
  const auto count = static_cast<std::size_t>(end - begin);
  const auto is_edge_renewed = [&](std::size_t i) {
    return which == Refresh::kAllAndEdges || IsFirstKnown(frames_[i]);
  };
  bool is_any_renewed = false;
  for (std::size_t k = 0; k < count; ++k) {
    const int u = begin + static_cast<int>(k);
    const std::size_t i = first + k;
    std::uint8_t& is_set = scratch_.is_set[k];
    is_set = 0;
    if (u < u_begin || u >= u_end) continue;
    if (which == Refresh::kYoung && frames_[i] == kMatureFrames) continue;
    if (!Knows(i)) {
      SetGatesOfUnknown(u, v, expected_m[i]);
      continue;
    }
    is_set = 1;
    is_any_renewed |= is_edge_renewed(i);
    const float axial_m = noise_.Axial_m(mean_m_[i]);
    prior_m2_[i] = axial_m * axial_m;
    scratch_.max_bend_m[k] = std::max(kMinBend_m, kBend_sigma * axial_m);
  }
  FindDepthsAround(v, begin, end);
  if (is_any_renewed) FindBends(scratch_.around(), count, scratch_.bends_m.data());
  bool has_edge = false;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = first + k;
    if (scratch_.is_set[k] == 0) continue;
    if (is_edge_renewed(i)) {
      is_edge_[i] = static_cast<std::uint8_t>(scratch_.bends_m[k] > scratch_.max_bend_m[k]);
    }
    has_edge |= is_edge_[i] != 0;
  }
  if (has_edge) {
    FindExtremes(scratch_.around(), count, scratch_.least_m.data(), scratch_.greatest_m.data());
  }
  SetGatesAbout(PixelsFrom(first),
                {.is_set = scratch_.is_set.data(),
                 .frames = frames_.data() + first,
                 .is_edge = is_edge_.data() + first,
                 .least_m = scratch_.least_m.data(),
                 .greatest_m = scratch_.greatest_m.data()},
                kMatureFrames, count, kMature);
}

// The depths about the pixels [begin, end) of a row; infinite where nothing is known, also outside
// of the image.
void ReferenceImage::FindDepthsAround(int v, int begin, int end) {
  constexpr int kBeside = static_cast<int>(kBeside_px);
  const int known_begin = std::max(0, begin - kBeside);
  const int known_end = std::min(width_, end + kBeside);
  for (int dv = -kBeside; dv <= kBeside; ++dv) {
    float* const row_m = scratch_.Depths_m(dv).data();
    if (v + dv < 0 || v + dv >= height_) {
      std::fill_n(row_m, end - begin + 2 * kBeside, kInfinite_m);
      continue;
    }
    const std::uint8_t* const frames = frames_.data() + At(known_begin, v + dv);
    const float* const mean_m = mean_m_.data() + At(known_begin, v + dv);
    float* const out_m = std::fill_n(row_m, known_begin - (begin - kBeside), kInfinite_m);
    CopyKnown(mean_m, frames, static_cast<std::size_t>(known_end - known_begin), out_m);
    std::fill_n(out_m + (known_end - known_begin), end + kBeside - known_end, kInfinite_m);
  }
}

void ReferenceImage::SetGatesOfUnknown(int u, int v, float expected_m) {
  const std::size_t i = At(u, v);
  low_m_[i] = expected_m == kInfinite_m
                  ? hole_low_m_[static_cast<std::size_t>(v / kBlock_px) * block_columns_ +
                                static_cast<std::size_t>(u / kBlock_px)]
                  : kInfinite_m;
  high_m_[i] = kInfinite_m;
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
