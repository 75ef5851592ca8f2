#include "perception/live/shape_fusion.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

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

std::vector<PlacedModel> PlacedSupports(std::span<const KnownBody> bodies) {
  std::vector<PlacedModel> supports;
  for (const KnownBody& body : bodies) {
    if (body.kind == KnownBody::Kind::kSupport) supports.push_back(PlacedBody(body));
  }
  return supports;
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

double Gate_m(const SensorNoise& noise, double range_m) {
  return kGate_sigma * std::hypot(noise.AxialSigma_m(range_m), noise.WarpSigma_m());
}

// Calls use(p_W, gate_m, u, v) for each measured point of a view in a box.
template <class Use>
void ForPointsIn(const Aabb& box_W, const MeanView& view, const PixelRays& rays, const Use& use) {
  const PixelRectangle pixels = PixelsOf(box_W, view);
  for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
    for (int u = pixels.u_begin; u < pixels.u_end; ++u) {
      const float z = view.depth_m[static_cast<std::size_t>(v) * view.camera.width + u];
      if (z == 0) continue;
      const Vector3 p_W = view.X_WC.translation() + rays.Point(u, v, z).cast<double>();
      if (box_W.contains(p_W)) use(p_W, Gate_m(view.noise, z), u, v);
    }
  }
}

// True if the other one takes up space of the body: nearly all of its surface lies in the body's
// solid or within noise of it, and most of it in the solid itself. A thing that lies flat on the
// body fails the second condition.
bool IsInside(const PlacedModel& own, const PlacedModel& other, double gate_m) {
  if (!Inflated(own.bounds_W, gate_m).intersects(other.bounds_W)) return false;
  const Pose X_OwnOther = own.X_BW * other.X_BW.inverse();
  const std::vector<SurfaceSample> samples = other.surface.Samples(kSurfaceSamples);
  const auto share_within = [&](double reach_m) {
    const auto within = std::ranges::count_if(samples, [&](const SurfaceSample& sample) {
      const auto nearest = own.surface.Nearest(X_OwnOther * sample.p_O);
      return nearest && nearest->signed_distance_m <= reach_m;
    });
    return static_cast<double>(within) / static_cast<double>(samples.size());
  };
  return !samples.empty() && share_within(gate_m) >= kNearlyAll && share_within(0) >= kMajority;
}

// True if nearly all points of the other one lie on the surface of the body.
bool ShowsSurfaceOf(const PlacedModel& own, const PlacedModel& other,
                    const std::vector<PlacedModel>& supports, std::span<const MeanView> views) {
  std::size_t of_other = 0;
  std::size_t of_both = 0;
  for (const MeanView& view : views) {
    const PixelRays rays(view.camera, view.X_WC);
    ForPointsIn(Inflated(other.bounds_W, kAround_m), view, rays,
                [&](const Vector3& p_W, double gate_m, int /*u*/, int /*v*/) {
                  const double distance_m = other.Distance_m(p_W, kAround_m);
                  const bool is_of_support =
                      std::ranges::any_of(supports, [&](const PlacedModel& support) {
                        return support.Distance_m(p_W, kAround_m) <= distance_m;
                      });
                  if (distance_m > gate_m || is_of_support) return;
                  ++of_other;
                  of_both += own.Distance_m(p_W, kAround_m) <= gate_m ? 1 : 0;
                });
  }
  return of_other >= kMinViewPoints &&
         static_cast<double>(of_both) >= kNearlyAll * static_cast<double>(of_other);
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

// Takes away the surfaces of the object's model that lie on a support.
void DropSurfacesOn(const std::vector<PlacedModel>& supports, double gate_m,
                    DetectedObject& object) {
  auto model = std::make_shared<HybridModel>(*object.model);
  std::erase_if(model->surfaces, [&](const SurfacePart& part) {
    const std::vector<Vector3>& vertices_O = part.surface.mesh->vertices;
    const auto on_support = std::ranges::count_if(vertices_O, [&](const Vector3& p_O) {
      return std::ranges::any_of(supports, [&](const PlacedModel& support) {
        return support.Distance_m(object.X_WO * p_O, kAround_m) <= gate_m;
      });
    });
    return static_cast<double>(on_support) >= kNearlyAll * static_cast<double>(vertices_O.size());
  });
  object.model = std::move(model);
}

// Takes the offset of each view off its points; those of the cloud end at `ends`, by view.
void RemoveOffsets(const KnownBody& body, const SensorNoise& noise,
                   const std::vector<std::size_t>& ends, FusionCloud& fused) {
  if (body.model->shapes.size() != 1) return;  // no known sizes that a fit may change
  const ShapePart& part = body.model->shapes.front();
  const std::vector<double> offsets_m =
      ViewOffsets_m(fused.own_C, part.shape, fused.X_WC.inverse() * body.X_WB * part.X_OS, noise);
  std::size_t i = 0;
  for (std::size_t v = 0; v < ends.size(); ++v) {
    BodyView& view = fused.own_C[v];
    const Eigen::Vector3f sensor_C = view.sensor.cast<float>();
    const auto offset_m = static_cast<float>(offsets_m[v]);
    const auto move = [&](Eigen::Vector3f& p) { p -= offset_m * (p - sensor_C).normalized(); };
    for (; i < ends[v]; ++i) move(fused.cloud.points[i]);
    for (Eigen::Vector3f& p : view.points) move(p);
  }
}

}  // namespace

std::vector<BodyId> PartsOf(std::span<const MeanView> views, const KnownBody& body,
                            std::span<const KnownBody> bodies) {
  const PlacedModel own = PlacedBody(body);
  const double gate_m = Gate_m(views.front().noise,
                               (own.bounds_W.center() - views.front().X_WC.translation()).norm());
  const std::vector<PlacedModel> supports = PlacedSupports(bodies);
  std::vector<BodyId> parts;
  for (const KnownBody& other : bodies) {
    const bool may_be_part = other.id != body.id && (other.kind == KnownBody::Kind::kObject ||
                                                     other.kind == KnownBody::Kind::kResidual);
    if (!may_be_part) continue;
    const PlacedModel placed = PlacedBody(other);
    if (IsInside(own, placed, gate_m) && ShowsSurfaceOf(own, placed, supports, views)) {
      parts.push_back(other.id);
    }
  }
  return parts;
}

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
  std::vector<std::size_t> ends;
  for (const MeanView& view : views) {
    const PixelRays rays(view.camera, view.X_WC);
    BodyView& own_C = fused.own_C.emplace_back();
    own_C.sensor = view.X_WC.translation() - fused.X_WC.translation();
    ForPointsIn(context_W, view, rays, [&](const Vector3& p_W, double gate_m, int u, int v) {
      const double of_body_m = own.Distance_m(p_W, kAround_m);
      bool is_of_support = false;
      bool is_of_other = false;
      for (const PlacedModel& other : others) {
        const double distance_m = other.Distance_m(p_W, kAround_m);
        if (distance_m > gate_m) continue;
        (other.is_support ? is_of_support : is_of_other) |= distance_m < of_body_m;
      }
      if (is_of_other || (!is_of_support && !near_W.contains(p_W))) return;
      const Eigen::Vector3f p_C = (p_W - fused.X_WC.translation()).cast<float>();
      fused.cloud.points.push_back(p_C);
      fused.cloud.normals.push_back(NormalAt(view, rays, u, v));
      if (!is_of_support && of_body_m <= gate_m) own_C.points.push_back(p_C);
    });
    ends.push_back(fused.cloud.points.size());
  }
  RemoveOffsets(body, views.front().noise, ends, fused);
  fused.cloud.width = static_cast<int>(fused.cloud.points.size());
  return fused;
}

std::optional<DetectedObject> FusedObject(const FusionCloud& fused,
                                          const SceneInterpretation& scene, const KnownBody& body,
                                          std::span<const KnownBody> bodies,
                                          const SensorNoise& noise) {
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
  DetectedObject object = scene.objects[static_cast<std::size_t>(*best)];
  if (object.model == nullptr || object.model->shapes.empty()) return std::nullopt;
  const double range_m = (body.X_WB.translation() - fused.X_WC.translation()).norm();
  DropSurfacesOn(PlacedSupports(bodies), Gate_m(noise, range_m), object);
  const Pose X_CW = fused.X_WC.inverse();
  for (const BodyView& view : fused.own_C) {
    const std::vector<Eigen::Vector3f>& own_C = view.points;
    if (own_C.size() < kMinViewPoints) continue;
    const double range_m = (own_C.front().cast<double>() - view.sensor).norm();
    const double within_m = Gate_m(noise, range_m);
    const double before = ShareNear(own_C, *body.model, X_CW * body.X_WB, within_m);
    const double after = ShareNear(own_C, *object.model, X_CW * object.X_WO, within_m);
    if (after < before - kEqualShare) return std::nullopt;
  }
  return object;
}

}  // namespace cwm::perception
