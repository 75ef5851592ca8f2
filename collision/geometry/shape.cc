#include "collision/geometry/shape.h"

#include <utility>

namespace cwm {
namespace {

// True if both meshes have the same content. Addresses are compared first, since most copies are
// shared.
bool SameMesh(const std::shared_ptr<const TriangleMesh>& a,
              const std::shared_ptr<const TriangleMesh>& b) {
  return a == b || (a != nullptr && b != nullptr && *a == *b);
}

bool SameCaps(const Mesh& a, const Mesh& b) {
  return a.caps == b.caps || (a.caps != nullptr && b.caps != nullptr && *a.caps == *b.caps);
}

}  // namespace

bool operator==(const Convex& a, const Convex& b) { return SameMesh(a.hull, b.hull); }

bool operator==(const Mesh& a, const Mesh& b) {
  return a.watertight == b.watertight && SameMesh(a.mesh, b.mesh) && SameCaps(a, b);
}

Mesh MakeMesh(TriangleMesh mesh) {
  auto shared = std::make_shared<const TriangleMesh>(std::move(mesh));
  const bool watertight = IsWatertight(*shared);
  return {.mesh = std::move(shared), .watertight = watertight};
}

bool HasCaps(const Shape& shape) {
  const auto* mesh = std::get_if<Mesh>(&shape);
  return mesh != nullptr && mesh->caps != nullptr;
}

std::string_view NameOf(ShapeKind kind) {
  switch (kind) {
    case ShapeKind::kSphere:
      return "sphere";
    case ShapeKind::kBox:
      return "box";
    case ShapeKind::kCylinder:
      return "cylinder";
    case ShapeKind::kCone:
      return "cone";
    case ShapeKind::kCapsule:
      return "capsule";
    case ShapeKind::kHalfSpace:
      return "half_space";
    case ShapeKind::kPlate:
      return "plate";
    case ShapeKind::kConvex:
      return "convex";
    case ShapeKind::kMesh:
      return "mesh";
  }
  return "unknown";
}

bool IsConvex(ShapeKind kind) { return kind != ShapeKind::kPlate && kind != ShapeKind::kMesh; }

}  // namespace cwm
