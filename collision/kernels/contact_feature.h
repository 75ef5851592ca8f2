// The face, edge or corner of a convex solid that is foremost along a direction.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {

// A sine: faces and edges that lean by no more against a plane across the direction are foremost
// with the corner that is. Poses of fitted things that stand on each other differ by up to a degree.
inline constexpr double kMostLean = 0.02;

struct ContactFeature {
  // Of a face with more, those are kept that are farthest in as many directions.
  static constexpr int kMostCorners = 32;

  std::array<Vector3, kMostCorners> corners;  // on the surface, those of a face in their order
  int count = 0;                              // 1: a point; 2: a line; more: a plane face
  Vector3 normal = Vector3::UnitZ();          // of a face: outward, unit

  void Add(const Vector3& corner) { corners[static_cast<std::size_t>(count++)] = corner; }
};

// Of one of the shape's convex pieces, along a unit direction, all in the shape's frame. Discs count
// by corners of an inscribed polygon; a round edge and a ball have a point alone. Linear in the
// triangles of a hull and the corners of a plate.
ContactFeature ForemostFeature(const ExactGeometry& shape, std::size_t piece, const Vector3& d);

// Which side of a triangle is that of the air.
enum class AirSide { kOfNormal, kBoth };

// The same of one triangle of a surface; nothing where it faces the other way.
std::optional<ContactFeature> ForemostFeature(const TriangleCorners& triangle, AirSide air,
                                              const Vector3& d);

}  // namespace cwm::collision
