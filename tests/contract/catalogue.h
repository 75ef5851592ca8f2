// Shapes and placements on which every engine is tested.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "collision/engines/engine.h"
#include "collision/geometry/shape.h"

namespace cwm::collision {

struct CatalogueShape {
  std::string name;
  Shape shape;
  double size_m = 0;  // about its radius, which determines the spread of placements
};

// At least one shape of each kind; cones of all forms, a concave plate with a hole, a closed and an
// open mesh.
const std::vector<CatalogueShape>& Catalogue();

// Closed meshes of a box and of an L-shaped prism, oriented outward.
TriangleMesh BoxMesh(const Vector3& size_m);
TriangleMesh ElbowMesh();

Pose RandomPose(std::mt19937& random, double spread_m);

// An engine's representation of a shape, at a pose.
struct PlacedShape {
  ShapeKind kind;
  std::shared_ptr<const EngineGeometry> geometry;
  Pose X_WS;

  PlacedGeometry get() const { return {kind, *geometry, X_WS}; }
};

inline PlacedShape Place(const Engine& engine, const Shape& shape, const Pose& X_WS) {
  return {KindOf(shape), engine.Prepare(shape), X_WS};
}

}  // namespace cwm::collision
