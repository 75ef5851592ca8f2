#include "perception/live/robot_claims.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "perception/live/box_edges.h"

#include "perception/live/frame_classes.h"

namespace cwm::perception {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr auto kRobotPixel = static_cast<std::uint8_t>(PixelClass::kRobot);
constexpr auto kCarriedPixel = static_cast<std::uint8_t>(PixelClass::kCarried);
constexpr auto kMixedPixelOfRobot = static_cast<std::uint8_t>(PixelClass::kMixed);

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

// Calls claim(pixel, p_L) for each pixel with a return, within the bounds, that may be
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
          claim(pixel, Eigen::Vector3f(body.origin_L + depth_m * (first_L + steps * step_L)));
        }
      }
    }
  }
}

// The distance of a point from where a known surface is expected along its ray; infinite if that is
// farther than noise explains.
float ExpectedDistance_m(const ClaimFrame& frame, std::size_t pixel) {
  const float depth_m = frame.image->depth_m[pixel];
  if (!frame.IsExpected(pixel, depth_m)) return kInfinity;
  const auto width = static_cast<std::size_t>(frame.camera->width);
  const float along_ray =
      frame.Point(static_cast<int>(pixel % width), static_cast<int>(pixel / width), 1).norm();
  return along_ray * std::abs(depth_m - frame.expected.At(pixel));
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

DepthTolerance::DepthTolerance(const SensorNoise& noise, float greatest_range_m)
    : steps_per_m_(kSteps / greatest_range_m) {
  for (std::size_t step = 0; step < at_steps_m_.size(); ++step) {
    const double depth_m = static_cast<double>(step + 1) / steps_per_m_;
    at_steps_m_[step] = static_cast<float>(
        kGate_sigma * std::hypot(noise.AxialSigma_m(depth_m), noise.WarpSigma_m()));
  }
}

bool ClaimFrame::IsExpected(std::size_t pixel, float depth_m) const {
  return std::abs(depth_m - expected.At(pixel)) <= tolerance.At_m(depth_m);
}

void ClaimPixels(const ClaimFrame& frame, std::span<const BodyInView> bodies,
                 std::span<const BodyInView> carried, std::span<std::uint8_t> pixels) {
  const auto is_taken = [&](const BodyInView& body, std::size_t pixel) {
    return pixels[pixel] == kRobotPixel || (body.is_carried && pixels[pixel] != 0);
  };
  const auto claim = [&](const BodyInView& body, std::size_t pixel) {
    pixels[pixel] = body.is_carried ? kCarriedPixel : kRobotPixel;
  };
  // Points beside two links are open for one of them and within the margin of the other, so what is
  // quick goes first.
  struct Open {
    const BodyInView* body;
    std::size_t pixel;
    Eigen::Vector3f p_L;
    bool is_contested;
  };
  std::vector<Open> open;
  for (const BodyInView& body : bodies) {
    const auto judge = [&](std::size_t pixel, const Eigen::Vector3f& p_L) {
      if (is_taken(body, pixel)) return;
      const DistanceGrid::Bounds bounds = body.surface->BoundsAt(p_L);
      const LinkSurface::Proximity quick = LinkSurface::Quick(bounds, body.margin_m);
      if (quick == LinkSurface::Proximity::kBeyond) return;
      // A point within noise of the body is the body's, whatever else is known there.
      const bool is_surely_near = bounds.greatest_m <= body.slack_m;
      const float expected_m = is_surely_near ? kInfinity : ExpectedDistance_m(frame, pixel);
      if (bounds.least_m > body.slack_m && expected_m <= bounds.least_m) return;
      const bool is_contested = pixels[pixel] == kCarriedPixel || expected_m < kInfinity;
      if (quick == LinkSurface::Proximity::kWithin && !is_contested) {
        claim(body, pixel);
      } else {
        open.push_back({&body, pixel, p_L, is_contested});
      }
    };
    ForEachNearPixel(frame, body, body.margin_m, body.bounds, judge);
  }
  for (const Open& candidate : open) {
    const BodyInView& body = *candidate.body;
    if (is_taken(body, candidate.pixel)) continue;
    if (!candidate.is_contested) {
      if (body.surface->IsWithin(candidate.p_L, body.margin_m)) claim(body, candidate.pixel);
      continue;
    }
    const double distance_m = body.surface->Distance_m(candidate.p_L, body.margin_m);
    if (std::isinf(distance_m)) continue;
    if (pixels[candidate.pixel] == kCarriedPixel) {
      const Eigen::Vector3f p_C = body.R_LC.transpose() * (candidate.p_L - body.origin_L);
      if (CarriedDistance_m(carried, p_C) <= distance_m) continue;
    } else if (distance_m > body.slack_m &&
               ExpectedDistance_m(frame, candidate.pixel) <= distance_m) {
      continue;
    }
    claim(body, candidate.pixel);
  }
}

void ClaimAsMixed(const ClaimFrame& frame, const BodyInView& body, float margin_m,
                  const PixelBounds& bounds, std::span<std::uint8_t> pixels) {
  const auto claim = [&](std::size_t pixel, const Eigen::Vector3f& p_L) {
    if (pixels[pixel] != 0 || !body.surface->IsWithin(p_L, margin_m)) return;
    if (!frame.IsExpected(pixel, frame.image->depth_m[pixel])) pixels[pixel] = kMixedPixelOfRobot;
  };
  ForEachNearPixel(frame, body, margin_m, bounds, claim);
}

}  // namespace cwm::perception
