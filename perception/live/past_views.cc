#include "perception/live/past_views.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace cwm::perception {
namespace {

using std::chrono::milliseconds;

// chosen: the newest kept frame is so old that what moves by a few centimetres a second has left
// its place; the oldest, that what rests for longer is interpreted by then.
constexpr milliseconds kApart{200};
constexpr std::size_t kKept = 8;
// chosen: the rays around the place must all end behind it, within the blur of edges and two
// standard deviations of the error of both poses, but not farther than the width of a finger at
// 0.6 m.
constexpr int kBlur_px = 2;
constexpr double kAround_sigma = 2;
constexpr int kMaxAround_px = 12;
// chosen: depth cameras measure least well in the outermost pixels.
constexpr int kOutermost_px = 2 * kBlock_px;

}  // namespace

void PastViews::Keep(std::shared_ptr<const DepthImage> image, const Pose& X_WC,
                     const PoseSigma& sigma, Stamp stamp) {
  if (!views_.empty() && stamp - views_.back().stamp < kApart) return;
  views_.push_back(
      {.image = std::move(image), .X_CW = X_WC.inverse(), .sigma = sigma, .stamp = stamp});
  if (views_.size() > kKept) views_.pop_front();
}

bool PastViews::SawThrough(const Vector3& p_W, const PoseSigma& sigma) const {
  const Pinhole& pinhole = camera_.pinhole;
  for (const View& view : views_) {
    const Vector3 p_C = view.X_CW * p_W;
    if (p_C.z() < camera_.least_range_m) continue;
    const auto u =
        static_cast<int>(std::lround(pinhole.focal_u_px * p_C.x() / p_C.z() + pinhole.center_u_px));
    const auto v =
        static_cast<int>(std::lround(pinhole.focal_v_px * p_C.y() / p_C.z() + pinhole.center_v_px));
    if (u < 0 || v < 0 || u >= camera_.width || v >= camera_.height) continue;
    // Most places that are asked for are not free, which their own ray tells.
    if (view.image->at(u, v) <= p_C.z() + 2 * kExplainedWithin_m) continue;
    const double turn_rad = std::hypot(sigma.rotation_rad, view.sigma.rotation_rad);
    const double shift_m = std::hypot(sigma.translation_m, view.sigma.translation_m);
    const double error_px = pinhole.focal_u_px * std::hypot(turn_rad, shift_m / p_C.z());
    const int around_px =
        std::min(kMaxAround_px, kBlur_px + static_cast<int>(std::ceil(kAround_sigma * error_px)));
    const int margin_px = kOutermost_px + around_px;
    if (u < margin_px || v < margin_px || u >= camera_.width - margin_px ||
        v >= camera_.height - margin_px) {
      continue;
    }
    const auto depth_m = static_cast<float>(p_C.z());
    const double gate_m = std::max(2 * kExplainedWithin_m,
                                   kDifference_sigma * std::hypot(noise_.Axial_m(depth_m), shift_m,
                                                                  noise_.model().WarpSigma_m()));
    const auto behind_m = static_cast<float>(p_C.z() + gate_m);
    bool is_behind = true;
    for (const int radius_px : {0, around_px / 2, around_px}) {
      for (int k = 0; k < 9 && is_behind; ++k) {
        const int du = (k % 3 - 1) * radius_px;
        const int dv = (k / 3 - 1) * radius_px;
        is_behind = view.image->at(u + du, v + dv) > behind_m;
      }
    }
    if (is_behind) return true;
  }
  return false;
}

}  // namespace cwm::perception
