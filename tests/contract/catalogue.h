// Shapes and placements that every engine is tried on.
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
  double size_m = 0;  // about its radius: how far placements must spread to touch and to miss
};

// At least one of each kind; cones of all forms, a concave plate with a hole, a closed and an open
// mesh.
const std::vector<CatalogueShape>& Catalogue();

// A mesh of the box, and of an L-shaped prism: closed, outward.
TriangleMesh BoxMesh(const Vector3& size_m);
TriangleMesh ElbowMesh();

Pose RandomPose(std::mt19937& random, double spread_m);

// An engine's own geometry of a shape, at a pose.
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
