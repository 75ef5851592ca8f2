// What the exact kernels keep of a shape: see PrepareExact.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/built_once.h"
#include "collision/kernels/convex_core.h"
#include "collision/kernels/mesh_hulls.h"
#include "collision/kernels/triangle_tree.h"

namespace cwm::collision {

// Immutable. Cores refer to vertices that live here or in the shape, hence neither copy nor move.
class ExactGeometry {
 public:
  // Incomplete, not to be asked, where `work` ended it.
  explicit ExactGeometry(const Shape& shape, WorkCounter* work = nullptr);
  ExactGeometry(const ExactGeometry&) = delete;
  ExactGeometry& operator=(const ExactGeometry&) = delete;

  ShapeKind kind() const { return KindOf(shape_); }
  const Shape& shape() const { return shape_; }  // a hull without degenerate triangles

  // The convex parts that cover the solid: one for a convex shape, prisms for a plate, none for a
  // half-space or mesh.
  const std::vector<ConvexCore>& pieces() const { return pieces_; }
  const std::vector<Aabb>& piece_bounds() const { return piece_bounds_; }

  // A convex solid around the whole: the plate's hull, the mesh's box. Only for these two.
  const ConvexCore& enclosure() const { return enclosure_; }
  const Pose& X_SE() const { return X_SE_; }  // where the enclosure lies in the shape's frame

  // Present for meshes only; of closed ones the normals point outward.
  const TriangleTree* tree() const { return tree_ ? &*tree_ : nullptr; }
  bool IsOpen() const;
  // Of a mesh, where it has them: built by the first who asks, since most meshes of a scan are
  // never asked about, while others wait. nullptr too where `work` ended that.
  const MeshHulls* hulls(WorkCounter* work = nullptr) const;

 private:
  void AddPlate(const Plate& plate);
  void AddMesh(const Mesh& mesh, WorkCounter* work);
  // Of many corners, the farthest along a direction is found by lanes.
  ConvexCore WithLanes(ConvexCore core);

  const Shape shape_;
  std::vector<std::vector<Vector3>> prisms_;
  std::vector<Vector3> enclosing_prism_;
  std::vector<std::unique_ptr<const VertexLanes>> lanes_;
  std::vector<ConvexCore> pieces_;
  std::vector<Aabb> piece_bounds_;
  ConvexCore enclosure_;
  Pose X_SE_ = Pose::Identity();
  std::optional<TriangleTree> tree_;
  BuiltOnce<std::unique_ptr<const MeshHulls>> hulls_;
};

}  // namespace cwm::collision
