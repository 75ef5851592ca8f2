#include "collision/kernels/exact_geometry.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "collision/geometry/mesh_parts.h"

namespace cwm::collision {
namespace {

std::vector<Vector3> Prism(const Polygon& outline, double thickness_m) {
  std::vector<Vector3> vertices;
  vertices.reserve(2 * outline.size());
  for (const double z : {0.0, -thickness_m}) {
    for (const Vector2& p : outline) vertices.emplace_back(p.x(), p.y(), z);
  }
  return vertices;
}

Aabb BoundsOf(const std::vector<Vector3>& points) {
  Aabb bounds;
  for (const Vector3& p : points) bounds.extend(p);
  return bounds;
}

// The shape, with a hull rebuilt from its corners: a hull from a client is convex only up to the
// rounding of single precision, and the planes of its narrow triangles would cut into it.
Shape Normalised(const Shape& shape, WorkCounter* work) {
  const auto* convex = std::get_if<Convex>(&shape);
  if (convex == nullptr) return shape;
  TriangleMesh hull = ConvexHull3(convex->hull->vertices, work);
  if (hull.triangles.empty()) return shape;  // too flat: kept with its rounded planes
  return Convex{std::make_shared<const TriangleMesh>(std::move(hull))};
}

}  // namespace

ExactGeometry::ExactGeometry(const Shape& shape, WorkCounter* work)
    : shape_(Normalised(shape, work)) {
  if (HasEnded(work)) return;
  if (const auto* plate = std::get_if<Plate>(&shape_)) {
    AddPlate(*plate);
  } else if (const auto* mesh = std::get_if<Mesh>(&shape_)) {
    AddMesh(*mesh, work);
  } else if (kind() != ShapeKind::kHalfSpace) {
    pieces_.push_back(WithLanes(CoreOf(shape_)));
    piece_bounds_.push_back(TightBounds(shape_, Pose::Identity()));
  }
}

void ExactGeometry::AddPlate(const Plate& plate) {
  for (const Polygon& piece : ConvexPieces(plate.outline, plate.holes)) {
    prisms_.push_back(Prism(piece, plate.thickness_m));
  }
  for (const std::vector<Vector3>& prism : prisms_) {
    pieces_.push_back(WithLanes(CoreOf(std::span(prism))));
    piece_bounds_.push_back(BoundsOf(prism));
  }
  enclosing_prism_ = Prism(ConvexHull(plate.outline), plate.thickness_m);
  enclosure_ = WithLanes(CoreOf(std::span(std::as_const(enclosing_prism_))));
}

ConvexCore ExactGeometry::WithLanes(ConvexCore core) {
  auto* hull = std::get_if<VertexCore>(&core.core);
  if (hull == nullptr || hull->vertices.size() < VertexLanes::kMin) return core;
  hull->lanes = lanes_.emplace_back(std::make_unique<const VertexLanes>(hull->vertices)).get();
  return core;
}

void ExactGeometry::AddMesh(const Mesh& mesh, WorkCounter* work) {
  const std::vector<std::uint32_t> components = ConnectedComponents(*mesh.mesh, work);
  if (HasEnded(work)) return;
  // A solid that is wound inward is turned, so that all reported normals point outward.
  std::vector<bool> is_turned;
  if (mesh.watertight) is_turned = TrianglesWoundInward(*mesh.mesh, components, work);
  tree_.emplace(*mesh.mesh, components, is_turned, work);
  if (HasEnded(work)) return;
  enclosure_ = CoreOf(Box{tree_->bounds().sizes()});
  X_SE_.translation() = tree_->bounds().center();
  if (mesh.caps != nullptr) AddCaps(*mesh.caps);
}

void ExactGeometry::AddCaps(const std::vector<MeshCap>& caps) {
  for (const MeshCap& cap : caps) {
    const Vector3 along = cap.axis[1] - cap.axis[0];
    Cap placed{.around = std::make_unique<const ExactGeometry>(
                   Capsule{.radius_m = cap.radius_m, .length_m = along.norm()}),
               .X_SC = MakePose(0.5 * (cap.axis[0] + cap.axis[1]),
                                Quaternion::FromTwoVectors(Vector3::UnitZ(), along)),
               .bound_m = cap.bound_m()};
    caps_.push_back(std::move(placed));
  }
  std::ranges::sort(caps_, std::greater<>(), &Cap::bound_m);
}

bool ExactGeometry::IsOpen() const {
  const auto* mesh = std::get_if<Mesh>(&shape_);
  return mesh != nullptr && !mesh->watertight;
}

const MeshHulls* ExactGeometry::hulls(WorkCounter* work) const {
  const auto* mesh = std::get_if<Mesh>(&shape_);
  if (mesh == nullptr) return nullptr;
  const auto* hulls = hulls_.Get([&] { return MeshHulls::Make(*mesh, *tree_, work); }, work);
  return hulls != nullptr ? hulls->get() : nullptr;
}

std::shared_ptr<const ExactGeometry> PrepareExact(const Shape& shape, WorkCounter* work) {
  auto geometry = std::make_shared<const ExactGeometry>(shape, work);
  return HasEnded(work) ? nullptr : geometry;
}

}  // namespace cwm::collision
