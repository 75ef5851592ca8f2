#include "perception/live/body_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cwm::perception {
namespace {

// chosen: normals are taken over two pixels on each side, within which the slope of the surface,
// as depth by width, must not change by more than this, as it does at edges.
constexpr int kNormalStep_px = 2;
constexpr float kMaxBend = 0.3F;
// chosen: beyond 80 degrees of incidence the depth says nothing about the surface.
constexpr float kGrazing_cos = 0.17F;
// chosen: a pixel that returns less often shows the fringe of something.
constexpr float kMinValidity = 0.5F;

constexpr float kNearOutline_m = 0.03F;  // see BodyEvidence::points_L
// chosen: the distance from the outline is measured in cells of this edge at least.
constexpr int kOutlineCell_px = 4;

std::size_t PixelIndex(int u, int v, int width) { return static_cast<std::size_t>(v) * width + u; }

}  // namespace

bool ExpectedPlaneAt(const ExpectedView& view, const DepthCamera& camera, int u, int v,
                     Eigen::Vector3f& plane_C) {
  constexpr int kStep = kNormalStep_px;
  if (u < kStep || v < kStep || u + kStep >= camera.width || v + kStep >= camera.height) {
    return false;
  }
  const std::vector<float>& depth = view.depth_m();
  const std::vector<BodyId>& body = view.body();
  const std::size_t i = PixelIndex(u, v, camera.width);
  const std::array<std::size_t, 4> beside = {i - kStep, i + kStep,
                                             PixelIndex(u, v - kStep, camera.width),
                                             PixelIndex(u, v + kStep, camera.width)};
  for (const std::size_t pixel : beside) {
    if (body[pixel] != body[i]) return false;
  }
  const auto focal_u = static_cast<float>(camera.pinhole.focal_u_px);
  const auto focal_v = static_cast<float>(camera.pinhole.focal_v_px);
  const float z = depth[i];
  const float bend_u = depth[beside[0]] + depth[beside[1]] - 2 * z;
  const float bend_v = depth[beside[2]] + depth[beside[3]] - 2 * z;
  const float widest = kMaxBend * kStep * z;
  if (std::abs(bend_u) * focal_u > widest || std::abs(bend_v) * focal_v > widest) return false;
  // Inverse depths are linear in the image for planes.
  const float w = 1 / z;
  const float w_u = (1 / depth[beside[1]] - 1 / depth[beside[0]]) / (2 * kStep);
  const float w_v = (1 / depth[beside[3]] - 1 / depth[beside[2]]) / (2 * kStep);
  const float from_u = static_cast<float>(u) - static_cast<float>(camera.pinhole.center_u_px);
  const float from_v = static_cast<float>(v) - static_cast<float>(camera.pinhole.center_v_px);
  plane_C = {w_u * focal_u, w_v * focal_v, w - w_u * from_u - w_v * from_v};
  const float ray =
      std::sqrt(1 + from_u * from_u / (focal_u * focal_u) + from_v * from_v / (focal_v * focal_v));
  return w >= kGrazing_cos * plane_C.norm() * ray;
}

void MotionTemplate::Build(const KnownBody& body, int pixels, bool has_moved,
                           const ExpectedView& view, const DepthCamera& camera,
                           const PixelRays& rays, const Pose& X_WC,
                           const ReferenceImage& reference) {
  const std::vector<Sample> before = std::exchange(samples_, {});
  information_.setZero();
  const PixelRectangle bounds = view.BoundsOf(body.id);
  const double share_each = static_cast<double>(pixels) / kMaxMotionPixels;
  const int least_stride = std::max(2, static_cast<int>(std::ceil(std::sqrt(share_each))));
  // Another grid would have to learn anew.
  if (has_moved || stride_ < least_stride || stride_ > 2 * least_stride) stride_ = least_stride;
  const int stride = stride_;
  // Each sample stands for the pixels around it, but says no more than one measurement.
  const double share = std::min(1.0, stride * stride / kPointsPerIndependentSample);
  const Eigen::Matrix3f R_WC = X_WC.linear().cast<float>();
  const Eigen::Vector3f origin_L = (body.X_WB.translation() - X_WC.translation()).cast<float>();
  const auto first = [stride](int begin) {
    return (begin + stride - 1) / stride * stride;  // a grid of the image, whatever the bounds
  };
  for (int v = first(bounds.v_begin); v < bounds.v_end; v += stride) {
    for (int u = first(bounds.u_begin); u < bounds.u_end; u += stride) {
      const std::size_t i = PixelIndex(u, v, camera.width);
      if (view.body()[i] != body.id || !reference.Knows(i) ||
          reference.Validity(i) < kMinValidity) {
        continue;
      }
      Eigen::Vector3f plane_C;
      if (!ExpectedPlaneAt(view, camera, u, v, plane_C)) continue;
      const float z = view.depth_m()[i];
      const Eigen::Vector3f by_translation = z * (R_WC * plane_C);  // n / (n * d)
      const Eigen::Vector3f by_rotation = (rays.Point(u, v, z) - origin_L).cross(by_translation);
      const float sigma_m = reference.Spread_m(i);
      Sample sample;
      sample.pixel = static_cast<std::int32_t>(i);
      sample.weight = static_cast<float>(share) / (sigma_m * sigma_m);
      Vector6 derivative;
      derivative << by_translation.cast<double>(), by_rotation.cast<double>();
      for (std::size_t k = 0; k < 6; ++k) {
        sample.derivative[k] = static_cast<float>(derivative[static_cast<Eigen::Index>(k)]);
      }
      const auto same = std::ranges::lower_bound(before, sample.pixel, {}, &Sample::pixel);
      if (!has_moved && same != before.end() && same->pixel == sample.pixel) {
        sample.depth_m = same->depth_m;
      }
      information_ += sample.weight * derivative * derivative.transpose();
      samples_.push_back(sample);
    }
  }
}

void MotionTemplate::Measure(const DepthImage& image, const FrameClasses& classes,
                             BodyEvidence& evidence) {
  std::array<float, 6> moment = {};
  Matrix6 silent = Matrix6::Zero();  // information of samples that say nothing
  int measured = 0;
  for (Sample& sample : samples_) {
    const auto i = static_cast<std::size_t>(sample.pixel);
    const float difference = image.depth_m[i] - sample.depth_m.mean;
    const PixelClass pixel = classes.pixels[i];
    const bool is_measured = pixel == PixelClass::kConsistent || pixel == PixelClass::kNearer ||
                             pixel == PixelClass::kFarther;
    const bool is_other = std::abs(difference) > static_cast<float>(kExplainedWithin_m);
    if (!is_measured || is_other || !sample.depth_m.HasLearnt()) {
      const Eigen::Map<const Eigen::Matrix<float, 6, 1>> derivative(sample.derivative.data());
      const Vector6 row = derivative.cast<double>();
      silent += sample.weight * row * row.transpose();
    } else {
      ++measured;
      const float weighted = sample.weight * difference;
      for (std::size_t k = 0; k < 6; ++k) moment[k] += weighted * sample.derivative[k];
    }
    if (pixel != PixelClass::kConsistent) continue;
    if (is_other && !sample.depth_m.HasLearnt()) sample.depth_m = {};
    if (!is_other || sample.depth_m.frames == 0) sample.depth_m.Learn(image.depth_m[i]);
  }
  evidence.moment_pixels = measured;
  if (measured == 0) return;
  evidence.information = information_ - silent;
  for (std::size_t k = 0; k < 6; ++k) evidence.moment[static_cast<Eigen::Index>(k)] = moment[k];
}

void MarkHotBodies(const FrameClasses& classes, const std::vector<BodyId>& body,
                   std::span<BodyEvidence> evidence) {
  BodyId last = kNoBody;
  std::size_t block = 0;
  for (int row = 0; row < classes.block_rows; ++row) {
    for (int column = 0; column < classes.block_columns; ++column, ++block) {
      if (classes.hot_blocks[block] == 0) continue;
      const PixelRectangle pixels = Grown({.u_begin = column * kBlock_px,
                                           .v_begin = row * kBlock_px,
                                           .u_end = (column + 1) * kBlock_px,
                                           .v_end = (row + 1) * kBlock_px},
                                          kBesideOutline_px, classes.width, classes.height);
      for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
        for (int u = pixels.u_begin; u < pixels.u_end; ++u) {
          const BodyId id = body[PixelIndex(u, v, classes.width)];
          if (id == last || id == kNoBody) continue;
          last = id;
          const auto found = std::ranges::lower_bound(evidence, id, {}, &BodyEvidence::id);
          if (found != evidence.end() && found->id == id) found->is_hot = true;
        }
      }
    }
  }
}

namespace {

// The step between pixels of which a large body has enough for a choice of kMaxBodyPoints.
int StrideOf(int seen_pixels) {
  return std::max(
      1, static_cast<int>(std::sqrt(static_cast<double>(seen_pixels) / (4 * kMaxBodyPoints))));
}

}  // namespace

void CountPassed(const ExpectedView& view, const DepthImage& image, const FrameClasses& classes,
                 const ReferenceImage& reference, const DepthNoise& noise, BodyEvidence& evidence) {
  const int stride = StrideOf(evidence.expected);
  const PixelRectangle bounds = view.BoundsOf(evidence.id);
  for (int v = bounds.v_begin; v < bounds.v_end; v += stride) {
    for (int u = bounds.u_begin; u < bounds.u_end; u += stride) {
      const std::size_t i = PixelIndex(u, v, image.width);
      const PixelClass pixel = classes.pixels[i];
      const bool is_measured = pixel == PixelClass::kConsistent || pixel == PixelClass::kFarther;
      if (view.body()[i] != evidence.id || !is_measured) continue;
      const float expected_m = view.depth_m()[i];
      const float explained_m = noise.Explained_m(expected_m);
      if (pixel == PixelClass::kFarther &&
          image.depth_m[i] - expected_m > kDifference_sigma * noise.Axial_m(expected_m)) {
        evidence.beyond += stride * stride;
      }
      float there_m = expected_m;
      float within_m = explained_m;
      if (reference.Knows(i)) {
        there_m = reference.mean_m()[i];
        within_m = kDifference_sigma * std::max(reference.Spread_m(i), noise.Axial_m(there_m));
        const bool flickers = within_m > explained_m;
        if (flickers || std::abs(there_m - expected_m) > explained_m) continue;
      }
      const float beyond_m = image.depth_m[i] - there_m;
      if (beyond_m > within_m) {
        evidence.passed += stride * stride;
      } else if (beyond_m >= -within_m) {
        evidence.shown += stride * stride;
      }
    }
  }
}

namespace {

// The distance of cells of the image from a body's pixels.
class OutlineDistance {
 public:
  OutlineDistance(BodyId id, const std::vector<BodyId>& body, const PixelRectangle& within,
                  int width, int stride)
      : origin_(within),
        cell_px_(std::max(kOutlineCell_px, stride)),
        columns_((within.u_end - within.u_begin) / cell_px_ + 1),
        rows_((within.v_end - within.v_begin) / cell_px_ + 1),
        distance_(static_cast<std::size_t>(columns_) * rows_, kFar) {
    for (int v = within.v_begin; v < within.v_end; v += stride) {
      for (int u = within.u_begin; u < within.u_end; u += stride) {
        if (body[PixelIndex(u, v, width)] == id) distance_[Cell(u, v)] = 0;
      }
    }
    // Chamfer distance (Borgefors 1986): 3 along rows and columns, 4 along diagonals.
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        Relax(column, row, {{{-1, 0, 3}, {-1, -1, 4}, {0, -1, 3}, {1, -1, 4}}});
      }
    }
    for (int row = rows_ - 1; row >= 0; --row) {
      for (int column = columns_ - 1; column >= 0; --column) {
        Relax(column, row, {{{1, 0, 3}, {1, 1, 4}, {0, 1, 3}, {-1, 1, 4}}});
      }
    }
  }

  float Distance_px(int u, int v) const {
    return static_cast<float>(distance_[Cell(u, v)]) * static_cast<float>(cell_px_) / 3;
  }

 private:
  static constexpr int kFar = std::numeric_limits<int>::max() / 2;
  struct Step {
    int columns, rows, length;
  };

  void Relax(int column, int row, const std::array<Step, 4>& steps) {
    int& own = distance_[static_cast<std::size_t>(row) * columns_ + column];
    for (const Step& step : steps) {
      const int c = column + step.columns;
      const int r = row + step.rows;
      if (c < 0 || c >= columns_ || r < 0 || r >= rows_) continue;
      own = std::min(own, distance_[static_cast<std::size_t>(r) * columns_ + c] + step.length);
    }
  }

  std::size_t Cell(int u, int v) const {
    return static_cast<std::size_t>((v - origin_.v_begin) / cell_px_) * columns_ +
           static_cast<std::size_t>((u - origin_.u_begin) / cell_px_);
  }

  PixelRectangle origin_;
  int cell_px_;
  int columns_;
  int rows_;
  std::vector<int> distance_;
};

}  // namespace

std::vector<Eigen::Vector3f> PointsOfBody(BodyId id, int seen_pixels, const ExpectedView& view,
                                          const DepthImage& image, const DepthCamera& camera,
                                          const FrameClasses& classes, const PixelRays& rays) {
  const int stride = StrideOf(seen_pixels);
  const PixelRectangle bounds = view.BoundsOf(id);
  float nearest_m = std::numeric_limits<float>::infinity();
  float farthest_m = 0;
  for (int v = bounds.v_begin; v < bounds.v_end; v += stride) {
    for (int u = bounds.u_begin; u < bounds.u_end; u += stride) {
      const std::size_t i = PixelIndex(u, v, camera.width);
      if (view.body()[i] != id) continue;
      nearest_m = std::min(nearest_m, view.depth_m()[i]);
      farthest_m = std::max(farthest_m, view.depth_m()[i]);
    }
  }
  if (nearest_m > farthest_m) return {};
  const auto focal_px =
      static_cast<float>(std::max(camera.pinhole.focal_u_px, camera.pinhole.focal_v_px));
  const float margin_px = std::min(static_cast<float>(std::max(camera.width, camera.height)),
                                   kNearOutline_m * focal_px / nearest_m);
  const PixelRectangle around =
      Grown(bounds, static_cast<int>(std::ceil(margin_px)), camera.width, camera.height);
  const OutlineDistance outline(id, view.body(), around, camera.width, stride);
  std::vector<std::int32_t> pixels;
  for (int v = around.v_begin; v < around.v_end; v += stride) {
    for (int u = around.u_begin; u < around.u_end; u += stride) {
      const std::size_t i = PixelIndex(u, v, camera.width);
      const PixelClass pixel = classes.pixels[i];
      const float z = image.depth_m[i];
      bool may_be_of_body = false;
      if (view.body()[i] == id) {
        const bool is_measured = pixel == PixelClass::kConsistent || pixel == PixelClass::kNearer ||
                                 pixel == PixelClass::kFarther;
        may_be_of_body = is_measured && std::abs(z - view.depth_m()[i]) <= kNearOutline_m;
      } else if (pixel == PixelClass::kNearer ||
                 (pixel == PixelClass::kConsistent &&
                  !(std::abs(z - view.depth_m()[i]) <= kExplainedWithin_m))) {
        // Beside the body only what no other body explains.
        may_be_of_body = z >= nearest_m - kNearOutline_m && z <= farthest_m + kNearOutline_m &&
                         outline.Distance_px(u, v) * z <= kNearOutline_m * focal_px;
      }
      if (may_be_of_body) pixels.push_back(static_cast<std::int32_t>(i));
    }
  }
  std::vector<Eigen::Vector3f> points_L;
  const std::size_t step = std::max<std::size_t>(
      1, (pixels.size() + kMaxBodyPoints - 1) / static_cast<std::size_t>(kMaxBodyPoints));
  for (std::size_t i = 0; i < pixels.size(); i += step) {
    const int u = pixels[i] % camera.width;
    const int v = pixels[i] / camera.width;
    points_L.push_back(rays.Point(u, v, image.depth_m[static_cast<std::size_t>(pixels[i])]));
  }
  return points_L;
}

}  // namespace cwm::perception
