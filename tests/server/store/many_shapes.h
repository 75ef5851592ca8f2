// Models with every kind of shape and part, for round trips through a store.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "collision/geometry/hybrid_model.h"
#include "collision/geometry/tessellate.h"
#include "tests/server/core/spindle.h"

namespace cwm::server {

// The sides of a Spindle whose encoding is a blob of its own, and of one that is part of a record.
inline constexpr std::uint32_t kSidesOfBlob = 1400, kSidesOfRecord = 12;

class ModelSource {
 public:
  explicit ModelSource(unsigned seed) : random_(seed) {}

  double Number(double min, double max) {
    return std::uniform_real_distribution<double>(min, max)(random_);
  }
  int Integer(int min, int max) { return std::uniform_int_distribution<int>(min, max)(random_); }
  Pose AnyPose() {
    const Vector3 axis = Vector3(Number(-1, 1), Number(-1, 1), Number(0.1, 1)).normalized();
    return MakePose({Number(-2, 2), Number(-2, 2), Number(-2, 2)},
                    Quaternion(Eigen::AngleAxisd(Number(-3, 3), axis)));
  }

  std::shared_ptr<const TriangleMesh> AnyMesh(std::uint32_t sides) {
    TriangleMesh mesh = Spindle(sides);
    const double scale = Number(0.05, 0.2);
    for (Vector3& p : mesh.vertices) p *= scale;
    return std::make_shared<const TriangleMesh>(std::move(mesh));
  }

  Shape AnyShape(ShapeKind kind) {
    switch (kind) {
      case ShapeKind::kSphere:
        return Sphere{Number(0.01, 0.3)};
      case ShapeKind::kBox:
        return Box{{Number(0.01, 0.3), Number(0.01, 0.3), Number(0.01, 0.3)}};
      case ShapeKind::kCylinder:
        return Cylinder{Number(0.01, 0.3), Number(0.01, 0.3)};
      case ShapeKind::kCone:
        return Cone{Number(0.01, 0.3), Integer(0, 1) * Number(0.01, 0.3), Number(0.01, 0.3)};
      case ShapeKind::kCapsule:
        return Capsule{Number(0.01, 0.3), Number(0.01, 0.3)};
      case ShapeKind::kHalfSpace:
        return HalfSpace{};
      case ShapeKind::kPlate:
        return Plate{.outline = {{-1, -1}, {1, -1}, {Number(0.9, 1.1), 1}, {-1, 1}},
                     .holes = {{{-0.5, -0.5}, {-0.1, -0.5}, {-0.1, -0.1}},
                               {{0.1, 0.1}, {0.5, 0.1}, {0.5, Number(0.4, 0.6)}}},
                     .thickness_m = Number(0.01, 0.1)};
      case ShapeKind::kConvex:
        return Convex{AnyMesh(kSidesOfRecord)};
      case ShapeKind::kMesh:
        break;
    }
    Mesh mesh{.mesh = AnyMesh(Integer(0, 3) == 0 ? kSidesOfBlob : kSidesOfRecord),
              .watertight = true};
    if (Integer(0, 1) == 1) {
      mesh.caps = std::make_shared<const std::vector<MeshCap>>(
          std::vector<MeshCap>{{.axis = {Vector3(0, 0, 0.01), Vector3(-0.0, Number(0, 1), 0)},
                                .radius_m = 0.01,
                                .diameter_m = 0.03}});
    }
    return mesh;
  }

  // A part with all that perception tells of it.
  ShapePart FullPart(ShapeKind kind) {
    ShapePart part{.X_OS = AnyPose(), .shape = AnyShape(kind), .role = PartRole::kCompleted};
    part.fit = FitQuality{.rms_m = Number(0, 1e-3),
                          .max_residual_m = 1e-300,  // subnormal squares, exact all the same
                          .inlier_count = Integer(1, 100'000),
                          .inlier_ratio = Number(0, 1),
                          .observed_fraction = Number(0, 1),
                          .parameter_sigma = {0.0, -0.0, 1e-5}};
    part.hidden = Placed<Box>{.X_FS = AnyPose(), .shape = {{0.1, 0.0, 0.3}}};
    return part;
  }

  std::shared_ptr<const HybridModel> FullModel() {
    HybridModel model;
    for (int kind = 0; kind < kShapeKindCount; ++kind) {
      model.shapes.push_back(FullPart(static_cast<ShapeKind>(kind)));
    }
    model.shapes.push_back({.X_OS = AnyPose(), .shape = Sphere{0.1}});
    auto vessel = std::make_shared<VesselShell>();
    vessel->outer = {{0.02, -0.05}, {0.04, 0.05}};
    vessel->inner = {{0.038, 0.05}, {0.018, -0.045}, {0, -0.045}};
    vessel->wall_thickness_m = 0.002;
    vessel->rim_radius_sigma_m = 1e-4;
    model.shapes.push_back({.X_OS = AnyPose(),
                            .shape = MakeMesh(Tessellate(*vessel, 1e-3)),
                            .fit = {},
                            .vessel = vessel});
    model.surfaces.push_back(
        {.surface = {.mesh = AnyMesh(kSidesOfBlob), .watertight = true}, .point_count = 7});
    model.surfaces.push_back({.surface = {.mesh = std::make_shared<const TriangleMesh>()}});
    Handle handle;
    handle.shape_index = 2;
    handle.point_count = 31;
    handle.axis_O = AnyPose().linear().col(0);
    handle.bounds = {.X_FS = AnyPose(), .shape = {{0.1, 0.02, 0.01}}};
    model.handles.push_back(handle);  // without a surface
    handle.shape_index = -1;
    handle.surface = {.mesh = AnyMesh(kSidesOfRecord), .watertight = false};
    model.handles.push_back(std::move(handle));
    model.point_count = 123'456;
    return std::make_shared<const HybridModel>(std::move(model));
  }

  // A cheap model: one shape of any bounded kind.
  std::shared_ptr<const HybridModel> SmallModel() {
    HybridModel model;
    auto kind = static_cast<ShapeKind>(Integer(0, kShapeKindCount - 1));
    if (kind == ShapeKind::kHalfSpace) kind = ShapeKind::kBox;
    model.shapes.push_back({.X_OS = AnyPose(), .shape = AnyShape(kind)});
    return std::make_shared<const HybridModel>(std::move(model));
  }

 private:
  std::mt19937 random_;
};

}  // namespace cwm::server
