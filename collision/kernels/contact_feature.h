// The face, edge or corner of a convex solid that is foremost along a direction.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {

// Sine of the largest angle between a face or edge and the plane across the direction at which it
// still counts as foremost together with the foremost corner. chosen: the poses of fitted objects
// that stand on each other differ by up to a degree.
inline constexpr double kMaxTilt = 0.02;

struct ContactFeature {
  // A face with more corners keeps those that are farthest in this many directions.
  static constexpr int kMaxCorners = 32;

  std::array<Vector3, kMaxCorners> corners;  // on the surface; those of a face in cyclic order
  int count = 0;                             // 1: a point; 2: a line; more: a plane face
  Vector3 normal = Vector3::UnitZ();         // outward unit normal of a face

  void Add(const Vector3& corner) { corners[static_cast<std::size_t>(count++)] = corner; }
};

// The foremost feature of one convex piece of the shape along a unit direction, all in the shape's
// frame. A disc is represented by an inscribed polygon; a round edge and a ball have only a point.
// The cost is linear in the triangles of a hull and the corners of a plate.
ContactFeature SupportFeature(const ExactGeometry& shape, std::size_t piece, const Vector3& d);

// The side of a triangle that faces free space.
enum class FreeSide { kNormalSide, kBoth };

// The foremost feature of one triangle of a surface; empty if the triangle faces the other way.
std::optional<ContactFeature> SupportFeature(const TriangleCorners& triangle, FreeSide free_side,
                                             const Vector3& d);

}  // namespace cwm::collision
