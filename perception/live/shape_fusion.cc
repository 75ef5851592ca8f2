#include "perception/live/shape_fusion.h"

#include <algorithm>
#include <cmath>

#include "perception/cloud/tolerances.h"
#include "perception/live/pixel_rays.h"
#include "perception/live/pixel_rectangle.h"
#include "perception/track/model_surface.h"

namespace cwm::perception {
namespace {

// chosen: what one sensor completed of a body may reach so much farther.
constexpr double kAround_m = 0.03;
// chosen: so much of what bears the body is seen around it, at least: a support is found by it.
constexpr double kContext_m = 0.12;
// chosen: a share of points by which two models explain equally much.
constexpr double kEqualShare = 0.03;
// chosen: pixels on each side of which normals are made, and the steepest slope of a surface.
constexpr int kSlopeStep_px = 3;
constexpr double kMaxSlope = 4;
// chosen: fewer points of a view say nothing.
constexpr std::size_t kMinViewPoints = kThreeSamples;

struct PlacedModel {
  ModelSurface surface;
  Pose X_BW = Pose::Identity();
  Aabb bounds_W;
  bool is_support = false;

  double Distance_m(const Vector3& p_W, double within_m) const {
    if (bounds_W.isEmpty() || bounds_W.exteriorDistance(p_W) > within_m) return within_m;
    const auto nearest = surface.Nearest(X_BW * p_W, within_m);
    return nearest ? std::min(within_m, std::abs(nearest->signed_distance_m)) : within_m;
  }
};

PlacedModel PlacedBody(const KnownBody& body) {
  return {.surface = ModelSurface(*body.model, kAround_m),
          .X_BW = body.X_WB.inverse(),
          .bounds_W = TightBounds(*body.model, body.X_WB),
          .is_support = body.kind == KnownBody::Kind::kSupport};
}

Aabb Inflated(const Aabb& bounds, double by_m) {
  return {bounds.min() - Vector3::Constant(by_m), bounds.max() + Vector3::Constant(by_m)};
}

// The pixels that may show the box; all if a part of it is behind the camera.
PixelRectangle PixelsOf(const Aabb& box_W, const MeanView& view) {
  const Pinhole& pinhole = view.camera.pinhole;
  PixelRectangle pixels{.u_begin = view.camera.width, .v_begin = view.camera.height};
  for (int i = 0; i < 8; ++i) {
    const Vector3 p_C = view.X_WC.inverse() * box_W.corner(static_cast<Aabb::CornerType>(i));
    if (p_C.z() < 0.05) return {.u_end = view.camera.width, .v_end = view.camera.height};
    const double u = pinhole.focal_u_px * p_C.x() / p_C.z() + pinhole.center_u_px;
    const double v = pinhole.focal_v_px * p_C.y() / p_C.z() + pinhole.center_v_px;
    pixels.u_begin = std::min(pixels.u_begin, static_cast<int>(std::floor(u)));
    pixels.v_begin = std::min(pixels.v_begin, static_cast<int>(std::floor(v)));
    pixels.u_end = std::max(pixels.u_end, static_cast<int>(std::ceil(u)) + 1);
    pixels.v_end = std::max(pixels.v_end, static_cast<int>(std::ceil(v)) + 1);
  }
  return Grown(pixels, 0, view.camera.width, view.camera.height);
}

// The normal, towards its sensor, of what a pixel shows, by the pixels beside it: the interpreter
// would turn all normals of merged views to one sensor. Zero beside edges.
Eigen::Vector3f NormalAt(const MeanView& view, const PixelRays& rays, int u, int v) {
  if (u < kSlopeStep_px || v < kSlopeStep_px || u + kSlopeStep_px >= view.camera.width ||
      v + kSlopeStep_px >= view.camera.height) {
    return Eigen::Vector3f::Zero();
  }
  const auto depth_m = [&](int at_u, int at_v) {
    return view.depth_m[static_cast<std::size_t>(at_v) * view.camera.width + at_u];
  };
  const float z = depth_m(u, v);
  const auto most_m =
      static_cast<float>(kMaxSlope * kSlopeStep_px * z / view.camera.pinhole.focal_u_px);
  const auto point = [&](int at_u, int at_v, Eigen::Vector3f& p) {
    const float near_m = depth_m(at_u, at_v);
    p = rays.Point(at_u, at_v, near_m);
    return near_m != 0 && std::abs(near_m - z) <= most_m;
  };
  Eigen::Vector3f left, right, above, below;
  const bool is_smooth = point(u - kSlopeStep_px, v, left) && point(u + kSlopeStep_px, v, right) &&
                         point(u, v - kSlopeStep_px, above) && point(u, v + kSlopeStep_px, below);
  if (!is_smooth) return Eigen::Vector3f::Zero();
  const Eigen::Vector3f normal = (right - left).cross(below - above).normalized();
  return normal.dot(rays.Direction(u, v)) > 0 ? Eigen::Vector3f(-normal) : normal;
}

double ShareNear(const std::vector<Eigen::Vector3f>& points_C, const HybridModel& model,
                 const Pose& X_CB, double within_m) {
  const ModelSurface surface(model, within_m);
  const Pose X_BC = X_CB.inverse();
  const auto explained = std::ranges::count_if(points_C, [&](const Eigen::Vector3f& p) {
    const auto nearest = surface.Nearest(X_BC * p.cast<double>(), within_m);
    return nearest && std::abs(nearest->signed_distance_m) <= within_m;
  });
  return points_C.empty() ? 0 : static_cast<double>(explained) / points_C.size();
}

}  // namespace

FusionCloud CloudOfBody(std::span<const MeanView> views, const KnownBody& body,
                        std::span<const KnownBody> bodies) {
  const PlacedModel own = PlacedBody(body);
  const Aabb near_W = Inflated(own.bounds_W, kAround_m);
  const Aabb context_W = Inflated(own.bounds_W, kContext_m);
  std::vector<PlacedModel> others;
  for (const KnownBody& other : bodies) {
    if (other.id == body.id || other.kind == KnownBody::Kind::kMover) continue;
    PlacedModel placed = PlacedBody(other);
    if (placed.bounds_W.intersects(context_W)) others.push_back(std::move(placed));
  }
  FusionCloud fused;
  fused.X_WC = Pose(Eigen::Translation3d(views.front().X_WC.translation()));
  fused.cloud.seen_from_origin = false;
  for (const MeanView& view : views) {
    const PixelRays rays(view.camera, view.X_WC);
    const PixelRectangle pixels = PixelsOf(context_W, view);
    std::vector<Eigen::Vector3f>& own_C = fused.own_C.emplace_back();
    for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
      for (int u = pixels.u_begin; u < pixels.u_end; ++u) {
        const float z = view.depth_m[static_cast<std::size_t>(v) * view.camera.width + u];
        if (z == 0) continue;
        const Vector3 p_W = view.X_WC.translation() + rays.Point(u, v, z).cast<double>();
        if (!context_W.contains(p_W)) continue;
        const double gate_m =
            kGate_sigma * std::hypot(view.noise.AxialSigma_m(z), view.noise.WarpSigma_m());
        const double of_body_m = own.Distance_m(p_W, kAround_m);
        bool is_of_support = false;
        bool is_of_other = false;
        for (const PlacedModel& other : others) {
          const double distance_m = other.Distance_m(p_W, kAround_m);
          if (distance_m > gate_m) continue;
          (other.is_support ? is_of_support : is_of_other) |= distance_m < of_body_m;
        }
        if (is_of_other || (!is_of_support && !near_W.contains(p_W))) continue;
        const Eigen::Vector3f p_C = (p_W - fused.X_WC.translation()).cast<float>();
        fused.cloud.points.push_back(p_C);
        fused.cloud.normals.push_back(NormalAt(view, rays, u, v));
        if (!is_of_support && of_body_m <= gate_m) own_C.push_back(p_C);
      }
    }
  }
  fused.cloud.width = static_cast<int>(fused.cloud.points.size());
  return fused;
}

std::optional<int> FusedObject(const FusionCloud& fused, const SceneInterpretation& scene,
                               const KnownBody& body, const SensorNoise& noise) {
  const Vector3& origin_W = scene.X_WC.translation();
  const Aabb near_W = Inflated(TightBounds(*body.model, body.X_WB), kAround_m);
  std::optional<int> best;
  std::size_t most = 0;
  std::size_t all = 0;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const DetectedObject& object = scene.objects[i];
    std::size_t count = 0;
    for (const Eigen::Vector3f& p_L : object.points_L) {
      count += near_W.contains(origin_W + p_L.cast<double>()) ? 1 : 0;
    }
    all += count;
    if (object.kind != DetectedKind::kObject || count <= most) continue;
    most = count;
    best = static_cast<int>(i);
  }
  if (!best || static_cast<double>(most) < kNearlyAll * static_cast<double>(all)) {
    return std::nullopt;  // it is in pieces
  }
  const DetectedObject& object = scene.objects[static_cast<std::size_t>(*best)];
  if (object.model == nullptr || object.model->shapes.empty()) return std::nullopt;
  const Pose X_CW = fused.X_WC.inverse();
  for (const std::vector<Eigen::Vector3f>& own_C : fused.own_C) {
    if (own_C.size() < kMinViewPoints) continue;
    const double range_m = own_C.front().cast<double>().norm();
    const double within_m =
        kGate_sigma * std::hypot(noise.AxialSigma_m(range_m), noise.WarpSigma_m());
    const double before = ShareNear(own_C, *body.model, X_CW * body.X_WB, within_m);
    const double after = ShareNear(own_C, *object.model, X_CW * object.X_WO, within_m);
    if (after < before - kEqualShare) return std::nullopt;
  }
  return best;
}

}  // namespace cwm::perception
