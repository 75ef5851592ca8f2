#include "perception/live/still_view.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace cwm::perception {
namespace {

constexpr float kInfinite_m = std::numeric_limits<float>::infinity();

// chosen: matching windows blur edges by two pixels, as for references.
constexpr int kNear_px = 2;
// chosen: weak returns flicker, but some within so many pixels still show their surface.
constexpr int kFar_px = 4;

// derived: a bend is told by a second difference, which has six times the variance of a depth; four
// standard deviations of that are an edge. chosen: at least 10 mm, which household goods do not
// bend within two pixels.
constexpr float kMinBend_m = 0.01F;
constexpr float kBend_sigma = 9.8F;

// Differences are added up over windows of 2 x 2 cells, at every cell, so that what differs lies
// well within one of them; and over patches, in which a small turn of the sensor adds up.
constexpr int kCell_px = 4;
constexpr int kPatch_cells = 8;
constexpr int kWindowPixels = 4 * kCell_px * kCell_px;
// derived: a thing of 30 mm that comes or goes at 1.2 m has 80 pixels beyond its edges, 36 of them
// in one window; one that moves by 20 mm there leaves a strip 6 pixels wide, 40 in one window.
// measured: folds of cloth and edges beyond 2 m that flicker in real images reach 20.
constexpr int kDifferentPixels = 24;
// chosen: fewer pixels tell no mean.
constexpr int kMinMeanPixels = kWindowPixels / 4;
// measured: the mean of a square moves from frame to frame by 0.76 mm at 8 pixels and by 0.38 mm at
// 32 (a stereo camera before a table at 0.9 m, axial noise 1.7 mm): so many of its pixels make one
// independent sample. The first is about kPointsPerIndependentSample.
constexpr float kPixelsPerSampleOfWindow = 13;
constexpr float kPixelsPerSampleOfPatch = 53;

// The differences of the pixels of a part of the image.
struct Sums {
  int pixels = 0;  // with a return in both frames, within their gates
  float difference_m = 0;
  float variance_m2 = 0;  // of the differences of the pixels
  int nearer = 0, farther = 0;
  int found = 0;  // new returns of surfaces that the image does not show nearby

  Sums& operator+=(const Sums& other) {
    pixels += other.pixels;
    difference_m += other.difference_m;
    variance_m2 += other.variance_m2;
    nearer += other.nearer;
    farther += other.farther;
    found += other.found;
    return *this;
  }
  bool MeanDiffers(float pixels_per_sample) const {
    if (pixels < kMinMeanPixels) return false;
    const float limit_m = kDifference_sigma * std::sqrt(variance_m2 * pixels_per_sample);
    return std::abs(difference_m) > limit_m;
  }
  bool WindowDiffers() const {
    return nearer >= kDifferentPixels || farther >= kDifferentPixels ||
           found >= kWindowPixels / 2 || MeanDiffers(kPixelsPerSampleOfWindow);
  }
};

struct DepthRange {
  float low_m = kInfinite_m;
  float high_m = 0;
  bool empty() const { return low_m > high_m; }
};

float Square(float value) { return value * value; }

// The depth of a pixel; `otherwise_m` outside of the image and without a return.
float DepthOr(const DepthImage& image, int u, int v, float otherwise_m) {
  if (u < 0 || u >= image.width || v < 0 || v >= image.height) return otherwise_m;
  const float depth_m = image.at(u, v);
  return depth_m == 0 ? otherwise_m : depth_m;
}

// The noise of a depth, and of the place that the pixel shows on a slanted surface. Pixels two
// apart tell its slope, on the side on which it is the lesser: the other may be beyond an edge.
float Variance_m2(const DepthImage& image, const DepthNoise& noise, int u, int v) {
  const float center = image.at(u, v);
  const auto side = [&](int du, int dv) {
    return std::abs(DepthOr(image, u + du, v + dv, center) - center);
  };
  const float slope_m =
      std::max(std::min(side(-2, 0), side(2, 0)), std::min(side(0, -2), side(0, 2))) / 2;
  return Square(noise.Axial_m(center)) + Square(slope_m * noise.Lateral_px(center));
}

// The pixels within kFar_px of one, the nearest first.
struct Offset {
  int du = 0, dv = 0;
  int px2() const { return du * du + dv * dv; }
};
std::vector<Offset> OffsetsByDistance() {
  std::vector<Offset> offsets;
  for (int dv = -kFar_px; dv <= kFar_px; ++dv) {
    for (int du = -kFar_px; du <= kFar_px; ++du) offsets.push_back({du, dv});
  }
  std::ranges::stable_sort(offsets, {}, &Offset::px2);
  return offsets;
}

// Compares one frame with the image before.
class Matching {
 public:
  Matching(const DepthCamera& camera, const DepthNoise& noise, const DepthImage& before,
           const std::vector<float>& variance_m2, const DepthImage& now)
      : width_(camera.width),
        height_(camera.height),
        noise_(noise),
        before_(before),
        before_m_(before.depth_m),
        variance_m2_(variance_m2),
        now_m_(now.depth_m),
        columns_((width_ + kCell_px - 1) / kCell_px),
        rows_((height_ + kCell_px - 1) / kCell_px),
        source_(before_m_.size(), -1) {}

  std::optional<std::vector<std::int32_t>> Run() {
    std::vector<Sums> above(static_cast<std::size_t>(columns_));
    std::vector<Sums> patches(
        static_cast<std::size_t>((columns_ + kPatch_cells - 1) / kPatch_cells));
    for (int row = 0; row < rows_; ++row) {
      std::vector<Sums> cells = CompareRow(row);
      for (std::size_t i = 0; i < cells.size(); ++i) patches[i / kPatch_cells] += cells[i];
      if (row > 0 && AnyWindowDiffers(above, cells)) return std::nullopt;
      above.swap(cells);
      if ((row + 1) % kPatch_cells != 0 && row + 1 != rows_) continue;
      for (const Sums& patch : patches) {
        if (patch.MeanDiffers(kPixelsPerSampleOfPatch)) return std::nullopt;
      }
      std::ranges::fill(patches, Sums());
    }
    return std::move(source_);
  }

 private:
  std::size_t At(int u, int v) const { return static_cast<std::size_t>(v) * width_ + u; }

  static bool AnyWindowDiffers(const std::vector<Sums>& upper, const std::vector<Sums>& lower) {
    for (std::size_t i = 1; i < upper.size(); ++i) {
      Sums window = upper[i - 1];
      ((window += upper[i]) += lower[i - 1]) += lower[i];
      if (window.WindowDiffers()) return true;
    }
    return false;
  }

  std::vector<Sums> CompareRow(int row) {
    std::vector<Sums> cells(static_cast<std::size_t>(columns_));
    const int v_end = std::min(height_, (row + 1) * kCell_px);
    for (int v = row * kCell_px; v < v_end; ++v) {
      for (int u = 0; u < width_; ++u) {
        ComparePixel(u, v, cells[static_cast<std::size_t>(u / kCell_px)]);
      }
    }
    return cells;
  }

  void ComparePixel(int u, int v, Sums& sums) {
    const std::size_t i = At(u, v);
    const float before = before_m_[i];
    const float now = now_m_[i];
    if (now == 0) return;  // no evidence of anything
    if (before == 0) {
      const float gate_m = kDifference_sigma * std::sqrt(2 * Square(noise_.Axial_m(now)));
      source_[i] = NearestSame(u, v, kFar_px);
      sums.found += static_cast<int>(source_[i] < 0);
      if (!IsWithin(now, source_[i], u, v, gate_m)) Judge(now, RangeAround(u, v), gate_m, sums);
      return;
    }
    const float variance_m2 = 2 * variance_m2_[i];  // of both frames
    const float difference_m = now - before;
    if (Square(difference_m) <= Square(kDifference_sigma) * variance_m2) {
      ++sums.pixels;
      sums.difference_m += difference_m;
      sums.variance_m2 += variance_m2;
      source_[i] = static_cast<std::int32_t>(i);
      return;
    }
    const float gate_m = kDifference_sigma * std::sqrt(variance_m2);
    source_[i] = NearestSame(u, v, kNear_px);
    if (!IsEdge(u, v)) {
      Judge(now, {before, before}, gate_m, sums);
    } else if (!IsWithin(now, source_[i], u, v, gate_m)) {
      Judge(now, RangeAround(u, v), gate_m, sums);
    }
  }

  static void Judge(float now, const DepthRange& range, float gate_m, Sums& sums) {
    if (range.empty()) return;
    if (now < range.low_m - gate_m) ++sums.nearer;
    if (now > range.high_m + gate_m) ++sums.farther;
  }

  // True if a pixel of the range around (u, v) explains the depth, so that the range does.
  bool IsWithin(float now, std::int32_t pixel, int u, int v, float gate_m) const {
    if (pixel < 0) return false;
    const bool is_around =
        std::abs(pixel % width_ - u) <= kNear_px && std::abs(pixel / width_ - v) <= kNear_px;
    const float before = before_m_[static_cast<std::size_t>(pixel)];
    return is_around && now >= before - gate_m && now <= before + gate_m;
  }

  float Before(int u, int v, float otherwise_m) const {
    return DepthOr(before_, u, v, otherwise_m);
  }

  bool IsEdge(int u, int v) const {
    const float center = before_m_[At(u, v)];
    const float most = std::max(kMinBend_m, kBend_sigma * noise_.Axial_m(center));
    for (int step = 1; step <= kNear_px; ++step) {
      for (const auto& [du, dv] : {std::pair(step, 0), {0, step}, {step, step}, {step, -step}}) {
        const float sides = Before(u - du, v - dv, center) + Before(u + du, v + dv, center);
        if (std::abs(sides - 2 * center) > most) return true;
      }
    }
    return false;
  }

  DepthRange RangeAround(int u, int v) const {
    DepthRange range;
    for (int dv = -kNear_px; dv <= kNear_px; ++dv) {
      for (int du = -kNear_px; du <= kNear_px; ++du) {
        const float depth_m = Before(u + du, v + dv, 0);
        if (depth_m == 0) continue;
        range.low_m = std::min(range.low_m, depth_m);
        range.high_m = std::max(range.high_m, depth_m);
      }
    }
    return range;
  }

  // The pixel within `radius_px` whose depth before explains the one now: the nearest one, and of
  // equally near ones that of the most similar depth; -1 if there is none.
  std::int32_t NearestSame(int u, int v, int radius_px) const {
    static const std::vector<Offset> kOffsets = OffsetsByDistance();
    const float now = now_m_[At(u, v)];
    const float most_m = noise_.Explained_m(now);
    std::int32_t best = -1;
    int best_px2 = std::numeric_limits<int>::max();
    float best_m = kInfinite_m;
    for (const Offset& offset : kOffsets) {
      const auto& [du, dv] = offset;
      if (offset.px2() > best_px2 || offset.px2() > 2 * radius_px * radius_px) break;
      if (std::max(std::abs(du), std::abs(dv)) > radius_px) continue;
      const float apart_m = std::abs(Before(u + du, v + dv, kInfinite_m) - now);
      if (apart_m > most_m || apart_m >= best_m) continue;
      best = static_cast<std::int32_t>(At(u + du, v + dv));
      best_px2 = offset.px2();
      best_m = apart_m;
    }
    return best;
  }

  const int width_;
  const int height_;
  const DepthNoise& noise_;
  const DepthImage& before_;
  const std::vector<float>& before_m_;
  const std::vector<float>& variance_m2_;
  const std::vector<float>& now_m_;
  const int columns_;
  const int rows_;
  std::vector<std::int32_t> source_;
};

}  // namespace

StillView::StillView(const DepthCamera& camera, const SensorNoise& noise,
                     std::shared_ptr<const DepthImage> image)
    : camera_(camera), noise_(camera, noise), image_(std::move(image)) {
  assert(image_ != nullptr && image_->depth_m.size() == camera.pixel_count());
  variance_m2_.reserve(image_->depth_m.size());
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      variance_m2_.push_back(Variance_m2(*image_, noise_, u, v));
    }
  }
}

std::optional<std::vector<std::int32_t>> StillView::Match(const DepthImage& now) const {
  assert(now.depth_m.size() == camera_.pixel_count());
  return Matching(camera_, noise_, *image_, variance_m2_, now).Run();
}

}  // namespace cwm::perception
