#include "perception/live/robot_claims.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "perception/live/frame_classes.h"

namespace cwm::perception {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr auto kRobotPixel = static_cast<std::uint8_t>(PixelClass::kRobot);
constexpr auto kCarriedPixel = static_cast<std::uint8_t>(PixelClass::kCarried);
constexpr auto kMixedPixelOfRobot = static_cast<std::uint8_t>(PixelClass::kMixed);

// The corners of a box at each end of its twelve edges, as AlignedBox numbers them: a bit an axis.
constexpr std::array<std::array<int, 2>, 12> kBoxEdges = {{{0, 1},
                                                           {2, 3},
                                                           {4, 5},
                                                           {6, 7},
                                                           {0, 2},
                                                           {1, 3},
                                                           {4, 6},
                                                           {5, 7},
                                                           {0, 4},
                                                           {1, 5},
                                                           {2, 6},
                                                           {3, 7}}};

// A ball that holds the points of a block's pixels, between two depths.
struct BlockBall {
  Eigen::Vector3f center_C;
  float radius_m;
};

BlockBall BallOf(const DepthCamera& camera, const PixelBounds& block,
                 const BlockDepths::Range_m& depths) {
  const auto focal_u = static_cast<float>(camera.pinhole.focal_u_px);
  const auto focal_v = static_cast<float>(camera.pinhole.focal_v_px);
  const auto center_u = static_cast<float>(camera.pinhole.center_u_px);
  const auto center_v = static_cast<float>(camera.pinhole.center_v_px);
  const float half_u = 0.5F * static_cast<float>(block.u_end - 1 - block.u_begin) / focal_u;
  const float half_v = 0.5F * static_cast<float>(block.v_end - 1 - block.v_begin) / focal_v;
  const float x = (static_cast<float>(block.u_begin) - center_u) / focal_u + half_u;
  const float y = (static_cast<float>(block.v_begin) - center_v) / focal_v + half_v;
  const float z = 0.5F * (depths.least + depths.greatest);
  const float half_z = 0.5F * (depths.greatest - depths.least);
  const Eigen::Vector3f reach(half_u * depths.greatest + std::abs(x) * half_z,
                              half_v * depths.greatest + std::abs(y) * half_z, half_z);
  return {.center_C = {x * z, y * z, z}, .radius_m = reach.norm()};
}

// Calls claim(pixel, u, v, depth, p_L) for each pixel with a return, within the bounds, that may be
// within the margin of the body.
template <class Claim>
void ForEachNearPixel(const ClaimFrame& frame, const BodyInView& body, float margin_m,
                      const PixelBounds& bounds, const Claim& claim) {
  const DepthCamera& camera = *frame.camera;
  const auto focal_u = static_cast<float>(camera.pinhole.focal_u_px);
  const auto focal_v = static_cast<float>(camera.pinhole.focal_v_px);
  const auto center_u = static_cast<float>(camera.pinhole.center_u_px);
  const auto center_v = static_cast<float>(camera.pinhole.center_v_px);
  const Eigen::Vector3f step_L = body.R_LC.col(0) / focal_u;
  for (int row = bounds.v_begin / kBlock_px; row * kBlock_px < bounds.v_end; ++row) {
    for (int column = bounds.u_begin / kBlock_px; column * kBlock_px < bounds.u_end; ++column) {
      const BlockDepths::Range_m& depths = frame.blocks->at(column, row);
      if (depths.least > depths.greatest) continue;
      const PixelBounds block{.u_begin = column * kBlock_px,
                              .v_begin = row * kBlock_px,
                              .u_end = std::min((column + 1) * kBlock_px, camera.width),
                              .v_end = std::min((row + 1) * kBlock_px, camera.height)};
      const BlockBall ball = BallOf(camera, block, depths);
      if (!body.surface->MayBeWithin(body.InLink(ball.center_C), ball.radius_m, margin_m)) continue;
      for (int v = block.v_begin; v < block.v_end; ++v) {
        const Eigen::Vector3f first_L =
            body.R_LC.col(0) * ((static_cast<float>(block.u_begin) - center_u) / focal_u) +
            body.R_LC.col(1) * ((static_cast<float>(v) - center_v) / focal_v) + body.R_LC.col(2);
        const std::size_t first = static_cast<std::size_t>(v) * camera.width;
        for (int u = block.u_begin; u < block.u_end; ++u) {
          const std::size_t pixel = first + static_cast<std::size_t>(u);
          const float depth_m = frame.image->depth_m[pixel];
          if (depth_m == 0) continue;
          const auto steps = static_cast<float>(u - block.u_begin);
          claim(pixel, u, v, depth_m,
                Eigen::Vector3f(body.origin_L + depth_m * (first_L + steps * step_L)));
        }
      }
    }
  }
}

// True if a known surface is nearer to the point than the body is, beyond what noise and motion
// call for.
bool IsBetterExplained(const ClaimFrame& frame, const BodyInView& body, std::size_t pixel, int u,
                       int v, float depth_m, const Eigen::Vector3f& p_L) {
  if (!frame.IsExpected(pixel, depth_m) || body.surface->IsWithin(p_L, body.slack_m)) return false;
  const float along_ray = frame.Point(u, v, 1).norm();
  const float expected_m = along_ray * std::abs(depth_m - frame.expected.At(pixel));
  return expected_m <= body.surface->Distance_m(p_L, body.margin_m);
}

double CarriedDistance_m(std::span<const BodyInView> carried, const Eigen::Vector3f& p_C) {
  double distance_m = std::numeric_limits<double>::infinity();
  for (const BodyInView& body : carried) {
    distance_m = std::min(distance_m, body.surface->Distance_m(body.InLink(p_C), body.margin_m));
  }
  return distance_m;
}

}  // namespace

void PixelBounds::Extend(const PixelBounds& other) {
  if (other.empty()) return;
  if (empty()) {
    *this = other;
    return;
  }
  u_begin = std::min(u_begin, other.u_begin);
  v_begin = std::min(v_begin, other.v_begin);
  u_end = std::max(u_end, other.u_end);
  v_end = std::max(v_end, other.v_end);
}

PixelBounds ProjectBox(const Aabb& bounds_L, const Pose& X_CL, const DepthCamera& camera,
                       double nearest_m) {
  std::array<Vector3, 8> corners_C;
  for (int i = 0; i < 8; ++i) {
    corners_C[static_cast<std::size_t>(i)] =
        X_CL * bounds_L.corner(static_cast<Aabb::CornerType>(i));
  }
  Eigen::AlignedBox2d pixels;
  const auto extend = [&](const Vector3& p) {
    pixels.extend(Vector2(camera.pinhole.focal_u_px * p.x() / p.z() + camera.pinhole.center_u_px,
                          camera.pinhole.focal_v_px * p.y() / p.z() + camera.pinhole.center_v_px));
  };
  for (const Vector3& p : corners_C) {
    if (p.z() >= nearest_m) extend(p);
  }
  for (const auto& [i, j] : kBoxEdges) {
    const Vector3& from = corners_C[static_cast<std::size_t>(i)];
    const Vector3& to = corners_C[static_cast<std::size_t>(j)];
    if ((from.z() >= nearest_m) == (to.z() >= nearest_m)) continue;
    Vector3 cut = from + (nearest_m - from.z()) / (to.z() - from.z()) * (to - from);
    cut.z() = nearest_m;
    extend(cut);
  }
  if (pixels.isEmpty()) return {};
  const auto clamped = [](double px, int size) {
    return static_cast<int>(std::clamp(px, 0.0, static_cast<double>(size)));
  };
  return {.u_begin = clamped(std::floor(pixels.min().x()), camera.width),
          .v_begin = clamped(std::floor(pixels.min().y()), camera.height),
          .u_end = clamped(std::ceil(pixels.max().x()) + 1, camera.width),
          .v_end = clamped(std::ceil(pixels.max().y()) + 1, camera.height)};
}

float ExpectedSurfaces::At(std::size_t pixel) const {
  if (depth_m.empty()) return kInfinity;
  if (!body.empty() && std::find(ignored.begin(), ignored.end(), body[pixel]) != ignored.end()) {
    return kInfinity;
  }
  return depth_m[pixel];
}

void BlockDepths::Compute(const DepthImage& image, const PixelBounds& bounds) {
  columns_ = (image.width + kBlock_px - 1) / kBlock_px;
  const int rows = (image.height + kBlock_px - 1) / kBlock_px;
  ranges_.assign(static_cast<std::size_t>(columns_) * rows, {.least = kInfinity, .greatest = 0});
  const int column_begin = bounds.u_begin / kBlock_px;
  const int column_end = (bounds.u_end + kBlock_px - 1) / kBlock_px;
  const int row_begin = bounds.v_begin / kBlock_px * kBlock_px;
  const int row_end =
      std::min((bounds.v_end + kBlock_px - 1) / kBlock_px * kBlock_px, image.height);
  for (int v = row_begin; v < row_end; ++v) {
    Range_m* ranges = ranges_.data() + static_cast<std::size_t>(v / kBlock_px) * columns_;
    const float* depths_m = image.depth_m.data() + static_cast<std::size_t>(v) * image.width;
    for (int column = column_begin; column < column_end; ++column) {
      Range_m range = ranges[column];
      const int u_end = std::min((column + 1) * kBlock_px, image.width);
      for (int u = column * kBlock_px; u < u_end; ++u) {
        const float depth_m = depths_m[u];
        range.least = std::min(range.least, depth_m > 0 ? depth_m : kInfinity);
        range.greatest = std::max(range.greatest, depth_m);
      }
      ranges[column] = range;
    }
  }
}

Eigen::Vector3f ClaimFrame::Point(int u, int v, float depth_m) const {
  const Pinhole& pinhole = camera->pinhole;
  return {depth_m * static_cast<float>((u - pinhole.center_u_px) / pinhole.focal_u_px),
          depth_m * static_cast<float>((v - pinhole.center_v_px) / pinhole.focal_v_px), depth_m};
}

bool ClaimFrame::IsExpected(std::size_t pixel, float depth_m) const {
  const float expected_m = expected.At(pixel);
  if (expected_m == kInfinity) return false;
  const double sigma_m = std::hypot(noise->AxialSigma_m(depth_m), noise->WarpSigma_m());
  return std::abs(depth_m - expected_m) <= kGate_sigma * sigma_m;
}

void ClaimPixels(const ClaimFrame& frame, const BodyInView& body,
                 std::span<const BodyInView> carried, std::span<std::uint8_t> pixels) {
  const bool has_expected = !frame.expected.depth_m.empty();
  const auto claim = [&](std::size_t pixel, int u, int v, float depth_m,
                         const Eigen::Vector3f& p_L) {
    std::uint8_t& of_pixel = pixels[pixel];
    if (of_pixel == kRobotPixel || (body.is_carried && of_pixel != 0)) return;
    if (!body.surface->IsWithin(p_L, body.margin_m)) return;
    if (of_pixel == kCarriedPixel) {
      const double carried_m = CarriedDistance_m(carried, frame.Point(u, v, depth_m));
      if (carried_m <= body.surface->Distance_m(p_L, body.margin_m)) return;
    } else if (has_expected && IsBetterExplained(frame, body, pixel, u, v, depth_m, p_L)) {
      return;
    }
    of_pixel = body.is_carried ? kCarriedPixel : kRobotPixel;
  };
  ForEachNearPixel(frame, body, body.margin_m, body.bounds, claim);
}

void ClaimAsMixed(const ClaimFrame& frame, const BodyInView& body, float margin_m,
                  const PixelBounds& bounds, std::span<std::uint8_t> pixels) {
  const auto claim = [&](std::size_t pixel, int, int, float depth_m, const Eigen::Vector3f& p_L) {
    if (pixels[pixel] != 0 || !body.surface->IsWithin(p_L, margin_m)) return;
    if (!frame.IsExpected(pixel, depth_m)) pixels[pixel] = kMixedPixelOfRobot;
  };
  ForEachNearPixel(frame, body, margin_m, bounds, claim);
}

}  // namespace cwm::perception
