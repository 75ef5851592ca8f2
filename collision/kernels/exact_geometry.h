// A shape as the exact kernels use it: see PrepareExact.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/lazy.h"
#include "collision/kernels/convex_core.h"
#include "collision/kernels/mesh_hulls.h"
#include "collision/kernels/triangle_tree.h"

namespace cwm::collision {

// Immutable. Neither copied nor moved, because cores refer to vertices stored here or in the shape.
class ExactGeometry {
 public:
  // Incomplete and unusable if `work` ended it.
  explicit ExactGeometry(const Shape& shape, WorkCounter* work = nullptr);
  ExactGeometry(const ExactGeometry&) = delete;
  ExactGeometry& operator=(const ExactGeometry&) = delete;

  ShapeKind kind() const { return KindOf(shape_); }
  const Shape& shape() const { return shape_; }  // hulls are rebuilt from their corners

  // The convex parts that cover the solid: one for a convex shape, prisms for a plate, none for a
  // half-space or mesh.
  const std::vector<ConvexCore>& pieces() const { return pieces_; }
  const std::vector<Aabb>& piece_bounds() const { return piece_bounds_; }

  // A convex solid around a plate (its hull) or a mesh (its box). Valid for these two only.
  const ConvexCore& enclosure() const { return enclosure_; }
  const Pose& X_SE() const { return X_SE_; }  // pose of the enclosure in the shape's frame

  // The triangle tree of a mesh, nullptr for other shapes. Normals of a closed mesh point outward.
  const TriangleTree* tree() const { return tree_ ? &*tree_ : nullptr; }
  bool IsOpen() const;
  // A hole of a closed mesh that triangles of no file close (MeshCap), as the capsule around it in
  // the shape's frame.
  struct Cap {
    std::unique_ptr<const ExactGeometry> around;
    Pose X_SC = Pose::Identity();
    double bound_m = 0;
  };
  // Those with the largest bound first. Empty for other shapes.
  const std::vector<Cap>& caps() const { return caps_; }
  // The hulls of a mesh; nullptr for other shapes and for meshes without hulls, or if `work` ended
  // the building. The first caller builds them while others wait, since most meshes of a scan are
  // never tested.
  const MeshHulls* hulls(WorkCounter* work = nullptr) const;

 private:
  void AddPlate(const Plate& plate);
  void AddMesh(const Mesh& mesh, WorkCounter* work);
  void AddCaps(const std::vector<MeshCap>& caps);
  // The core with VertexLanes if it has many vertices, which find the farthest one by SIMD.
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
  std::vector<Cap> caps_;
  Lazy<std::unique_ptr<const MeshHulls>> hulls_;
};

}  // namespace cwm::collision
