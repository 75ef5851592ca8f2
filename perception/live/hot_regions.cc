#include "perception/live/hot_regions.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// chosen: a pixel is as before within this many standard deviations of the difference of two
// depths, and so must be this share of the pixels that return in both.
constexpr float kRestGate = 3 * std::numbers::sqrt2_v<float>;
constexpr double kRestShare = 0.85;
// chosen: depth cameras have no returns in the outermost pixels of an image.
constexpr int kCut_px = 2 * kBlock_px;
// chosen: the pixels of a block whose places in the world are looked at: every so many along rows
// and columns.
constexpr int kAgeStep_px = 4;
// chosen: so many of a block's 16 points must have entered, since single ones are mixed pixels.
constexpr std::size_t kMinEntered = 8;
// chosen: outlines flicker by so much (Kinect: 0.8 pixels, Nguyen et al. 2012).
constexpr int kFlicker_px = 1;

// True if the pixel, or what flickers beside it, has the depth.
bool Shows(const DepthImage& image, int u, int v, float depth_m, float gate_m) {
  float low_m = std::numeric_limits<float>::infinity();
  float high_m = 0;
  for (int y = std::max(0, v - kFlicker_px); y <= std::min(image.height - 1, v + kFlicker_px);
       ++y) {
    for (int x = std::max(0, u - kFlicker_px); x <= std::min(image.width - 1, u + kFlicker_px);
         ++x) {
      const float beside_m = image.at(x, y);
      if (beside_m == 0) continue;
      low_m = std::min(low_m, beside_m);
      high_m = std::max(high_m, beside_m);
    }
  }
  return depth_m >= low_m - gate_m && depth_m <= high_m + gate_m;
}

}  // namespace

HotRegions::HotRegions(const DepthCamera& camera, const DepthNoise& noise)
    : width_(camera.width),
      height_(camera.height),
      columns_((camera.width + kBlock_px - 1) / kBlock_px),
      rows_((camera.height + kBlock_px - 1) / kBlock_px),
      noise_(noise),
      rests_(static_cast<std::size_t>(columns_) * rows_),
      rested_depth_m_(camera.pixel_count(), 0) {}

void HotRegions::UpdateRest(const DepthImage& image, const FrameClasses& classes, Stamp stamp,
                            bool is_still) {
  for (std::size_t i = 0; i < rests_.size(); ++i) {
    Rest& rest = rests_[i];
    if (classes.hot_blocks[i] == 0) {
      rest.was_hot = false;
      continue;
    }
    const PixelRectangle pixels = classes.PixelsOf(static_cast<std::int32_t>(i));
    int same = 0;
    int both = 0;
    if (rest.was_hot && is_still) {
      for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
        for (int u = pixels.u_begin; u < pixels.u_end; ++u) {
          const float now_m = image.at(u, v);
          const float then_m = rested_depth_m_[static_cast<std::size_t>(v) * width_ + u];
          if (now_m == 0 || then_m == 0) continue;
          ++both;
          const float gate_m = kRestGate * noise_.Axial_m(then_m);
          const bool is_same =
              std::abs(now_m - then_m) <= gate_m || Shows(image, u, v, then_m, gate_m);
          same += is_same ? 1 : 0;
        }
      }
    }
    if (both > 0 && same >= kRestShare * both) {
      ++rest.frames;
      continue;
    }
    rest = {.was_hot = true, .since = stamp};
    for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
      const std::size_t row = static_cast<std::size_t>(v) * width_;
      std::copy(image.depth_m.begin() + static_cast<std::ptrdiff_t>(row) + pixels.u_begin,
                image.depth_m.begin() + static_cast<std::ptrdiff_t>(row) + pixels.u_end,
                rested_depth_m_.begin() + static_cast<std::ptrdiff_t>(row) + pixels.u_begin);
    }
  }
}

void HotRegions::UpdateRestInWorld(const DepthImage& image, const FrameClasses& classes,
                                   const PixelRays& rays, Stamp stamp, const Vector3& origin_W) {
  age_.Prune(stamp);
  std::vector<Rest> rests;
  for (std::size_t i = 0; i < rests_.size(); ++i) {
    rests_[i] = {.since = stamp};
    if (classes.hot_blocks[i] == 0) continue;
    const PixelRectangle pixels = classes.PixelsOf(static_cast<std::int32_t>(i));
    rests.clear();
    for (int v = pixels.v_begin + 1; v < pixels.v_end; v += kAgeStep_px) {
      for (int u = pixels.u_begin + 1; u < pixels.u_end; u += kAgeStep_px) {
        const std::size_t pixel = static_cast<std::size_t>(v) * width_ + u;
        if (classes.pixels[pixel] != PixelClass::kNearer) continue;
        const Vector3 p_W = origin_W + rays.Point(u, v, image.depth_m[pixel]).cast<double>();
        const SurfaceAge::Age& age = age_.See(p_W, stamp);
        rests.push_back({.frames = age.frames - 1, .since = age.since});
      }
    }
    if (rests.empty()) continue;
    const auto shortest = rests.begin() + static_cast<std::ptrdiff_t>(rests.size() / 2);
    std::ranges::nth_element(rests, shortest, {}, &Rest::frames);
    rests_[i] = *shortest;
  }
}

void HotRegions::KeepEntered(const MovingSensor& moving, std::size_t first,
                             std::vector<Eigen::Vector3f>& points_L) {
  const auto has_entered = [&](const Eigen::Vector3f& p_L) {
    return moving.past->SawThrough(moving.X_WC.translation() + p_L.cast<double>(), moving.sigma);
  };
  std::size_t kept = first;
  for (std::size_t i = first; i < points_L.size(); ++i) {
    // Most blocks have none, and some of their points tell.
    if (kept == first && i >= first + kMinEntered) break;
    if (has_entered(points_L[i])) points_L[kept++] = points_L[i];
  }
  points_L.resize(kept - first >= kMinEntered ? kept : first);
}

HotRegions::Rest HotRegions::RestOf(const std::vector<std::int32_t>& blocks, double share) const {
  std::vector<Rest> rests;
  rests.reserve(blocks.size());
  for (const std::int32_t block : blocks) {
    rests.push_back(rests_[static_cast<std::size_t>(block)]);
  }
  const auto shortest =
      rests.begin() + static_cast<std::ptrdiff_t>((1 - share) * static_cast<double>(rests.size()));
  std::ranges::nth_element(rests, shortest, {}, &Rest::frames);
  return *shortest;
}

HotRegion HotRegions::Describe(std::vector<std::int32_t> blocks, const View& view, Stamp stamp,
                               const MovingSensor* moving) const {
  std::ranges::sort(blocks);
  HotRegion region;
  const Rest rest = RestOf(blocks, kMainShare);
  region.rest_frames = rest.frames;
  region.rest_s = std::chrono::duration<double>(stamp - rest.since).count();
  region.half_rest_s = std::chrono::duration<double>(stamp - RestOf(blocks, 0.5).since).count();
  for (const std::int32_t block : blocks) {
    const PixelRectangle pixels = view.classes.PixelsOf(block);
    BodyId last = kNoBody;
    const std::size_t first_point = region.points_L.size();
    const int nearer_before = region.nearer;
    for (int v = pixels.v_begin; v < pixels.v_end; v += 2) {
      for (int u = pixels.u_begin; u < pixels.u_end; u += 2) {
        bool has_point = false;
        for (int dv = 0; dv < 2 && v + dv < pixels.v_end; ++dv) {
          for (int du = 0; du < 2 && u + du < pixels.u_end; ++du) {
            const std::size_t i = static_cast<std::size_t>(v + dv) * width_ + u + du;
            if (view.body[i] != kNoBody && view.body[i] != last) {
              last = view.body[i];
              region.bodies.push_back(last);
            }
            if (view.classes.pixels[i] == PixelClass::kFarther) ++region.farther;
            if (view.classes.pixels[i] != PixelClass::kNearer) continue;
            ++region.nearer;
            region.entered += view.reference.Knows(i) ? 1 : 0;
            if (std::exchange(has_point, true)) continue;
            region.points_L.push_back(view.rays.Point(u + du, v + dv, view.image.depth_m[i]));
          }
        }
      }
    }
    region.full_blocks += 2 * (region.nearer - nearer_before) >= kBlock_px * kBlock_px ? 1 : 0;
    region.is_cut |= pixels.u_begin < kCut_px || pixels.v_begin < kCut_px ||
                     pixels.u_end > width_ - kCut_px || pixels.v_end > height_ - kCut_px;
    if (moving != nullptr) KeepEntered(*moving, first_point, region.points_L);
  }
  std::ranges::sort(region.bodies);
  region.bodies.erase(std::unique(region.bodies.begin(), region.bodies.end()), region.bodies.end());
  region.blocks = std::move(blocks);
  return region;
}

std::vector<HotRegion> HotRegions::Find(const View& view, Stamp stamp, bool is_still,
                                        const MovingSensor* moving) {
  if (moving != nullptr) {
    UpdateRestInWorld(view.image, view.classes, view.rays, stamp, moving->X_WC.translation());
  } else {
    UpdateRest(view.image, view.classes, stamp, is_still);
  }
  std::vector<HotRegion> regions;
  std::vector<std::uint8_t> left = view.classes.hot_blocks;
  for (std::size_t first = 0; first < left.size(); ++first) {
    if (left[first] == 0) continue;
    left[first] = 0;
    std::vector<std::int32_t> blocks = {static_cast<std::int32_t>(first)};
    for (std::size_t next = 0; next < blocks.size(); ++next) {
      const int column = blocks[next] % columns_;
      const int row = blocks[next] / columns_;
      for (int r = std::max(0, row - 1); r < std::min(rows_, row + 2); ++r) {
        for (int c = std::max(0, column - 1); c < std::min(columns_, column + 2); ++c) {
          const std::size_t beside = static_cast<std::size_t>(r) * columns_ + c;
          if (std::exchange(left[beside], std::uint8_t{0}) == 0) continue;
          blocks.push_back(static_cast<std::int32_t>(beside));
        }
      }
    }
    regions.push_back(Describe(std::move(blocks), view, stamp, moving));
  }
  std::ranges::stable_sort(regions, std::greater(),
                           [](const HotRegion& region) { return region.blocks.size(); });
  return regions;
}

}  // namespace cwm::perception
