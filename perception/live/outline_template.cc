#include "perception/live/outline_template.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/track/ray_classification.h"

namespace cwm::perception {
namespace {

// derived: a shift of 5 mm is 3.3 pixels of a Kinect at 0.8 m; a longer one makes blocks hot.
constexpr int kReach_px = 4;
// derived: a thing of 200 mm shades so many pixels behind it from the projector of a Kinect at 1 m.
constexpr int kMaxGap_px = 8;
constexpr float kGapVariance_px2 = 0.1F;  // chosen: of a pixel that may or may not return
// chosen: models err by some millimetres, so that the drop is looked for so far from their outline.
constexpr int kSearch_px = 4;
// derived: over a smaller drop, the noise of 10 pixels would add a third of a pixel.
constexpr float kMinDrop_sigma = 10;
constexpr float kMinDrop_m = 2 * static_cast<float>(kExplainedWithin_m);
// chosen: the share of the drop over which a pixel shows both sides, so that a small change of the
// depth of either side is no shift.
constexpr float kBothSides = 0.5F;
// chosen: the normal is that of the body's pixels within this distance.
constexpr int kNormal_px = 4;
constexpr float kMinSigma_px = 0.25F;  // chosen: crossings that never flickered did so by luck

// The outward normal of the outline at a pixel of the body: away from the middle of the body's
// pixels around it. Empty if they say nothing.
std::optional<Eigen::Vector2f> NormalAt(BodyId id, const ExpectedView& view,
                                        const DepthCamera& camera, int u, int v) {
  Eigen::Vector2f sum = Eigen::Vector2f::Zero();
  for (int y = std::max(0, v - kNormal_px); y <= std::min(camera.height - 1, v + kNormal_px); ++y) {
    for (int x = std::max(0, u - kNormal_px); x <= std::min(camera.width - 1, u + kNormal_px);
         ++x) {
      if (view.body()[static_cast<std::size_t>(y) * camera.width + x] != id) continue;
      sum -= Eigen::Vector2f(static_cast<float>(x - u), static_cast<float>(y - v));
    }
  }
  const float norm = sum.norm();
  if (norm < 1) return std::nullopt;
  return sum / norm;
}

// The index of a pixel that is `count` steps from another one.
std::size_t PixelAt(std::int32_t first, std::int32_t step, int count) {
  const std::int32_t pixel = first + count * step;
  return static_cast<std::size_t>(pixel);
}

// Most pixels lie inside of a body or outside of it: groups of them are skipped at once.
constexpr int kGroup_px = 8;
static_assert(sizeof(BodyId) * kGroup_px == 2 * sizeof(std::uint64_t));

// True if all pixels of a group show the body.
bool AreAll(const BodyId* first, BodyId id) {
  constexpr std::uint64_t kEach = 0x0001'0001'0001'0001;
  std::array<std::uint64_t, 2> group{};
  std::memcpy(group.data(), first, sizeof(group));
  return group[0] == id * kEach && group[1] == id * kEach;
}

// True if no pixel of a group is a border of the body: none shows it, or all of them and those
// around them do.
bool HasNoBorder(const BodyId* first, BodyId id, int width) {
  if (!AreAll(first, *first)) return false;
  return *first != id || (first[-1] == id && first[kGroup_px] == id && AreAll(first - width, id) &&
                          AreAll(first + width, id));
}

bool IsMeasured(PixelClass pixel) {
  return pixel == PixelClass::kConsistent || pixel == PixelClass::kNearer ||
         pixel == PixelClass::kFarther;
}

}  // namespace

std::vector<OutlineTemplate::Border> OutlineTemplate::BordersOf(BodyId id, const ExpectedView& view,
                                                                const DepthCamera& camera) {
  constexpr int kMargin = kSearch_px + kMaxGap_px + kReach_px + 1;
  const PixelRectangle bounds = Intersection(view.BoundsOf(id), {.u_begin = kMargin,
                                                                 .v_begin = kMargin,
                                                                 .u_end = camera.width - kMargin,
                                                                 .v_end = camera.height - kMargin});
  const std::vector<BodyId>& body = view.body();
  std::vector<Border> borders;
  for (int v = bounds.v_begin; v < bounds.v_end; ++v) {
    for (int u = bounds.u_begin; u < bounds.u_end; ++u) {
      const auto pixel = static_cast<std::int32_t>(v * camera.width + u);
      if (u + kGroup_px <= bounds.u_end && HasNoBorder(body.data() + pixel, id, camera.width)) {
        u += kGroup_px - 1;
        continue;
      }
      if (body[static_cast<std::size_t>(pixel)] != id) continue;
      for (const std::int32_t step : {-1, 1, -camera.width, camera.width}) {
        if (body[PixelAt(pixel, step, 1)] != id) borders.push_back({pixel, step});
      }
    }
  }
  return borders;
}

bool OutlineTemplate::FindDrop(const Border& border, const ExpectedView& view,
                               const ReferenceImage& reference, const DepthNoise& noise,
                               Crossing& crossing) {
  const auto at = [&](int k) { return PixelAt(border.pixel, border.step, k); };
  const auto knows = [&](int k) { return reference.Knows(at(k)); };
  // The last pixel before the drop and the first one behind it.
  int last = 0;
  int next = 0;
  float largest_m = 0;
  int before = -kSearch_px - 1;
  for (int k = -kSearch_px; k <= kSearch_px + kMaxGap_px && before <= kSearch_px; ++k) {
    if (!knows(k)) continue;
    if (before >= -kSearch_px && k - before <= kMaxGap_px + 1) {
      const float step_m = reference.mean_m()[at(k)] - reference.mean_m()[at(before)];
      if (step_m > largest_m) {
        largest_m = step_m;
        last = before;
        next = k;
      }
    }
    before = k;
  }
  if (next == last) return false;
  const std::size_t inner = at(last - kReach_px);
  const std::size_t outer = at(next + kReach_px);
  if (!reference.HasSettled(inner) || !reference.HasSettled(outer)) return false;
  const float front_m = reference.mean_m()[inner];
  const float drop_m = reference.mean_m()[outer] - front_m;
  const float expected_m = view.depth_m()[static_cast<std::size_t>(border.pixel)];
  const float explained_m = noise.Explained_m(expected_m);
  if (std::abs(front_m - expected_m) > explained_m ||
      drop_m < std::max(kMinDrop_m, kMinDrop_sigma * noise.Axial_m(front_m + drop_m))) {
    return false;
  }
  float variance_px2 = 0;
  for (int k = last - kReach_px; k <= next + kReach_px; ++k) {
    const float spread_px = knows(k) ? reference.Spread_m(at(k)) / drop_m : 0;
    variance_px2 += knows(k) ? spread_px * spread_px : kGapVariance_px2;
  }
  crossing.pixel = static_cast<std::int32_t>(inner);
  crossing.count = next - last + 2 * kReach_px + 1;
  crossing.nearest_m = front_m - explained_m;
  crossing.near_m = front_m + 0.5F * (1 - kBothSides) * drop_m;
  crossing.far_m = front_m + 0.5F * (1 + kBothSides) * drop_m;
  crossing.far_within_m = std::max(static_cast<float>(kExplainedWithin_m),
                                   kDifference_sigma * noise.Axial_m(front_m + drop_m));
  crossing.sigma_px = std::max(kMinSigma_px, std::sqrt(variance_px2));
  return true;
}

void OutlineTemplate::Build(const KnownBody& body, bool has_moved, const ExpectedView& view,
                            const DepthCamera& camera, const PixelRays& rays, const Pose& X_WC,
                            const ReferenceImage& reference, const DepthNoise& noise) {
  const std::vector<Crossing> before = std::exchange(crossings_, {});
  const std::vector<Border> borders = BordersOf(body.id, view, camera);
  const std::size_t stride = 1 + borders.size() / kMaxCrossings;
  // Each stands for those beside it, but says no more than one measurement.
  const auto share = static_cast<float>(
      std::min(1.0, static_cast<double>(stride) / std::sqrt(kPointsPerIndependentSample)));
  const Eigen::Matrix3f R_WC = X_WC.linear().cast<float>();
  const Eigen::Vector3f origin_L = (body.X_WB.translation() - X_WC.translation()).cast<float>();
  const auto focal_u = static_cast<float>(camera.pinhole.focal_u_px);
  const auto focal_v = static_cast<float>(camera.pinhole.focal_v_px);
  for (const Border& border : borders) {
    if (static_cast<std::size_t>(border.pixel + std::abs(border.step)) % stride != 0) continue;
    const int u = border.pixel % camera.width;
    const int v = border.pixel / camera.width;
    const auto normal = NormalAt(body.id, view, camera, u, v);
    if (!normal) continue;
    const bool is_row = std::abs(border.step) == 1;
    const float along = std::abs(is_row ? normal->x() : normal->y());
    if (along < std::abs(is_row ? normal->y() : normal->x())) continue;
    Crossing crossing{.border = border};
    const auto same = std::ranges::lower_bound(before, border, {}, &Crossing::border);
    if (!has_moved && same != before.end() && same->border == border) {
      crossing = *same;
    } else if (!FindDrop(border, view, reference, noise, crossing)) {
      continue;
    }
    const float z = view.depth_m()[static_cast<std::size_t>(border.pixel)];
    const Eigen::Vector3f p_L = rays.Point(u, v, z);
    const Eigen::Vector3f p_C = R_WC.transpose() * p_L;
    const float by_u = focal_u * normal->x() / z;
    const float by_v = focal_v * normal->y() / z;
    const Eigen::Vector3f by_motion_C(by_u, by_v, -(by_u * p_C.x() + by_v * p_C.y()) / z);
    const Eigen::Vector3f by_translation = R_WC * by_motion_C / along;
    const Eigen::Vector3f by_rotation = (p_L - origin_L).cross(by_translation);
    crossing.weight = share / (crossing.sigma_px * crossing.sigma_px);
    Eigen::Map<Eigen::Matrix<float, 6, 1>> derivative(crossing.derivative.data());
    derivative << by_translation, by_rotation;
    crossings_.push_back(crossing);
  }
}

// The number of pixels of the crossing that show the body; negative if the frame cannot tell. A
// pixel without a return is as its neighbours are, on both sides.
float OutlineTemplate::PixelsOfBody(const Crossing& crossing, const DepthImage& image,
                                    const FrameClasses& classes, const ReferenceImage& reference) {
  const auto at = [&](int k) { return PixelAt(crossing.pixel, crossing.border.step, k); };
  const auto is_same = [&](std::size_t i, float within_m) {
    const float depth_m = image.depth_m[i];
    return depth_m != 0 && reference.Knows(i) &&
           std::abs(depth_m - reference.mean_m()[i]) <= within_m;
  };
  if (!is_same(at(0), static_cast<float>(kExplainedWithin_m)) ||
      !is_same(at(crossing.count - 1), crossing.far_within_m)) {
    return -1;
  }
  float pixels = 0;
  float before = 1;
  int missing = 0;
  for (int k = 0; k < crossing.count; ++k) {
    const std::size_t i = at(k);
    const float depth_m = image.depth_m[i];
    if (depth_m == 0) {
      ++missing;
      continue;
    }
    if (!IsMeasured(classes.pixels[i]) || depth_m < crossing.nearest_m) return -1;
    const float now =
        std::clamp((crossing.far_m - depth_m) / (crossing.far_m - crossing.near_m), 0.0F, 1.0F);
    pixels += now + 0.5F * static_cast<float>(missing) * (before + now);
    before = now;
    missing = 0;
  }
  return pixels;
}

void OutlineTemplate::Measure(const DepthImage& image, const FrameClasses& classes,
                              const ReferenceImage& reference, BodyEvidence& evidence) {
  for (Crossing& crossing : crossings_) {
    const float pixels = PixelsOfBody(crossing, image, classes, reference);
    if (pixels < 0) continue;
    if (crossing.usual_px.HasLearnt()) {
      const float shift_px = pixels - crossing.usual_px.mean;
      const Eigen::Map<const Eigen::Matrix<float, 6, 1>> derivative(crossing.derivative.data());
      const Vector6 row = derivative.cast<double>();
      evidence.information += crossing.weight * row * row.transpose();
      evidence.moment += crossing.weight * shift_px * row;
      ++evidence.moment_pixels;
    }
    crossing.usual_px.Learn(pixels);
  }
}

}  // namespace cwm::perception
