#include "collision/engines/bullet_geometry.h"

#include <algorithm>
#include <utility>

#include "collision/engines/convex_pieces.h"

namespace cwm::collision {
namespace {

// Removes the default margin (4 cm on most shapes), which would be added to every distance. Spheres
// and capsules keep theirs, which is their radius.
BulletPiece WithoutMargin(std::shared_ptr<btConvexShape> shape,
                          const Pose& X_SP = Pose::Identity()) {
  shape->setMargin(0);
  return {.shape = std::move(shape), .X_SP = X_SP};
}

BulletShape Single(std::shared_ptr<btConvexShape> shape, const Pose& X_SP = Pose::Identity()) {
  return {.pieces = {WithoutMargin(std::move(shape), X_SP)}, .bound_m = 0, .mesh = nullptr};
}

BulletPiece HullPiece(const TriangleMesh& hull) {
  auto shape = std::make_shared<btConvexHullShape>();
  for (const Vector3& v : hull.vertices)
    shape->addPoint(ToBullet(v), /*recalculateLocalAabb=*/false);
  shape->recalcLocalAabb();
  return WithoutMargin(std::move(shape));
}

BulletShape FromPieces(const ConvexPieceSet& set) {
  BulletShape shape;
  shape.bound_m = set.bound_m;
  for (const TriangleMesh& hull : set.hulls) shape.pieces.push_back(HullPiece(hull));
  return shape;
}

struct ToBulletShape {
  BulletShape operator()(const Sphere& s) const {
    return Single(std::make_shared<btSphereShape>(s.radius_m));
  }
  BulletShape operator()(const Box& s) const {
    return Single(std::make_shared<btBoxShape>(ToBullet(Vector3(0.5 * s.size_m))));
  }
  BulletShape operator()(const Cylinder& s) const {
    return Single(
        std::make_shared<btCylinderShapeZ>(btVector3(s.radius_m, s.radius_m, 0.5 * s.length_m)));
  }
  BulletShape operator()(const Cone& s) const {
    if (s.radius_bottom_m == s.radius_top_m) return (*this)(Cylinder{s.radius_top_m, s.length_m});
    if (s.radius_top_m == 0) {
      return Single(std::make_shared<btConeShapeZ>(s.radius_bottom_m, s.length_m));
    }
    if (s.radius_bottom_m == 0) {
      Pose X_SP = Pose::Identity();  // Bullet's apex is up: half a turn about x
      X_SP.linear() = Vector3(1, -1, -1).asDiagonal();
      return Single(std::make_shared<btConeShapeZ>(s.radius_top_m, s.length_m), X_SP);
    }
    return FromPieces(CircumscribedPieces(s));
  }
  BulletShape operator()(const Capsule& s) const {
    return Single(std::make_shared<btCapsuleShapeZ>(s.radius_m, s.length_m));
  }
  BulletShape operator()(const HalfSpace&) const { return {}; }
  BulletShape operator()(const Plate& s) const { return FromPieces(CircumscribedPieces(s)); }
  BulletShape operator()(const Convex& s) const {
    BulletShape shape;
    shape.pieces.push_back(HullPiece(*s.hull));
    return shape;
  }
  BulletShape operator()(const Mesh& s) const {
    BulletShape shape;
    shape.mesh = MakeBulletMesh(s.mesh);
    return shape;
  }
};

}  // namespace

btTransform ToBullet(const Pose& X) {
  const Matrix3 R = X.linear();
  const btMatrix3x3 basis(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1),
                          R(2, 2));
  return btTransform(basis, ToBullet(Vector3(X.translation())));
}

std::shared_ptr<const BulletMesh> MakeBulletMesh(std::shared_ptr<const TriangleMesh> source,
                                                 int triangles_per_part) {
  auto mesh = std::make_shared<BulletMesh>();
  mesh->source = std::move(source);
  mesh->indices.reserve(3 * mesh->source->triangles.size());
  for (const auto& t : mesh->source->triangles)
    mesh->indices.insert(mesh->indices.end(), t.begin(), t.end());
  static_assert(sizeof(Vector3) == 3 * sizeof(btScalar));
  const btScalar* vertices = mesh->source->vertices.front().data();
  mesh->arrays = std::make_unique<btTriangleIndexVertexArray>();
  const auto count = static_cast<int>(mesh->source->triangles.size());
  for (int first = 0; first < count; first += triangles_per_part) {
    btIndexedMesh part;
    part.m_numTriangles = std::min(triangles_per_part, count - first);
    part.m_triangleIndexBase =
        reinterpret_cast<const unsigned char*>(mesh->indices.data() + std::size_t{3} * first);
    part.m_triangleIndexStride = static_cast<int>(3 * sizeof(int));
    part.m_numVertices = static_cast<int>(mesh->source->vertices.size());
    part.m_vertexBase = reinterpret_cast<const unsigned char*>(vertices);
    part.m_vertexStride = static_cast<int>(sizeof(Vector3));
    mesh->arrays->addIndexedMesh(part, PHY_INTEGER);
  }
  auto shape = std::make_unique<btBvhTriangleMeshShape>(mesh->arrays.get(),
                                                        /*useQuantizedAabbCompression=*/true);
  shape->setMargin(0);
  mesh->shape = std::move(shape);
  return mesh;
}

BulletShape MakeBulletShape(const Shape& shape) { return std::visit(ToBulletShape{}, shape); }

}  // namespace cwm::collision
