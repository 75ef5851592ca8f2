// Shapes in Bullet's representation, with every collision margin at zero.
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

// A mesh and the arrays that Bullet's pointers refer to. Bullet writes to neither after
// construction.
struct BulletMesh {
  std::shared_ptr<const TriangleMesh> source;
  std::vector<int> indices;
  std::unique_ptr<btTriangleIndexVertexArray> arrays;  // split into parts that Bullet can index
  std::unique_ptr<const btBvhTriangleMeshShape> shape;
};

struct BulletShape {
  std::vector<BulletPiece> pieces;         // of a solid; empty for a half-space or a mesh
  double bound_m = 0;                      // how far the pieces reach beyond the shape
  std::shared_ptr<const BulletMesh> mesh;  // null for everything but a mesh
};

BulletShape MakeBulletShape(const Shape& shape);

// Bullet packs the number of a part and the index of a triangle into one int, unchecked. An index
// beyond this limit makes it read other memory.
inline constexpr int kMaxTrianglesPerPart = 1 << (31 - MAX_NUM_PARTS_IN_BITS);

// `triangles_per_part` is from 1 to kMaxTrianglesPerPart, and gives at most
// 2^MAX_NUM_PARTS_IN_BITS parts.
std::shared_ptr<const BulletMesh> MakeBulletMesh(std::shared_ptr<const TriangleMesh> source,
                                                 int triangles_per_part = kMaxTrianglesPerPart);

}  // namespace cwm::collision
