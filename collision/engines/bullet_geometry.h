// Shapes in Bullet's form, with every collision margin at zero.
#pragma once

#include <btBulletCollisionCommon.h>

#include <memory>
#include <vector>

#include "collision/geometry/shape.h"

namespace cwm::collision {

static_assert(sizeof(btScalar) == sizeof(double),
              "Debian ships Bullet twice; mixing float and double is silent corruption");

inline btVector3 ToBullet(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
inline Vector3 FromBullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
btTransform ToBullet(const Pose& X);

struct BulletPiece {
  std::shared_ptr<const btConvexShape> shape;
  Pose X_SP = Pose::Identity();  // the piece in the shape's frame
};

// A mesh and the arrays that Bullet points into. Bullet writes to neither after construction.
struct BulletMesh {
  std::shared_ptr<const TriangleMesh> source;
  std::vector<int> indices;
  std::unique_ptr<btTriangleIndexVertexArray> arrays;  // in parts that Bullet can count
  std::unique_ptr<const btBvhTriangleMeshShape> shape;
};

struct BulletShape {
  std::vector<BulletPiece> pieces;         // of a solid; none for a half-space or a mesh
  double bound_m = 0;                      // how far the pieces reach beyond the shape
  std::shared_ptr<const BulletMesh> mesh;  // of a mesh
};

BulletShape MakeBulletShape(const Shape& shape);

// Bullet keeps the index of a triangle in what the number of its part leaves of an int, unchecked;
// beyond, it reads other memory.
inline constexpr int kMostTrianglesPerPart = 1 << (31 - MAX_NUM_PARTS_IN_BITS);

// `triangles_per_part` from 1 to kMostTrianglesPerPart, and at most 2^MAX_NUM_PARTS_IN_BITS parts.
std::shared_ptr<const BulletMesh> MakeBulletMesh(std::shared_ptr<const TriangleMesh> source,
                                                 int triangles_per_part = kMostTrianglesPerPart);

}  // namespace cwm::collision
