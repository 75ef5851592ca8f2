#include "tests/benchmarks/quality/claimed_geometry.h"

#include <array>

namespace cwm::benchmarks {
namespace {

class Collector {
 public:
  explicit Collector(ClaimedGeometry& claims) : claims_(claims) {}

  void AddSolid(Claim claim, const Pose& X_CS, const Shape& shape) {
    ClaimedSolid& solid = claims_.solids.emplace_back();
    solid.claim = claim;
    solid.X_CS = X_CS;
    solid.shape = shape;
    solid.bounds_C = TightBounds(shape, X_CS);
  }

  void AddMesh(Claim claim, const Pose& X_CO, const Mesh& mesh) {
    if (mesh.mesh == nullptr) return;
    for (const TriangleMesh::Triangle& t : mesh.mesh->triangles) {
      ClaimedTriangle triangle{.claim = claim, .corners_C = {}};
      for (std::size_t k = 0; k < 3; ++k) {
        triangle.corners_C[k] = X_CO * mesh.mesh->vertices[t[k]];
      }
      claims_.triangles.push_back(triangle);
    }
    if (mesh.watertight && !mesh.mesh->triangles.empty()) AddSolid(claim, X_CO, mesh);
  }

  void AddModel(const Pose& X_CO, const HybridModel& model) {
    for (const ShapePart& part : model.shapes) {
      const Claim claim = part.role == PartRole::kFitted ? Claim::kFitted : Claim::kCompleted;
      AddSolid(claim, X_CO * part.X_OS, part.shape);
    }
    for (const SurfacePart& part : model.surfaces) AddMesh(Claim::kSurface, X_CO, part.surface);
    for (const Handle& handle : model.handles) {
      if (handle.surface.mesh != nullptr && !handle.surface.mesh->triangles.empty()) {
        AddMesh(Claim::kHandle, X_CO, handle.surface);
      } else {
        AddSolid(Claim::kHandle, X_CO * handle.bounds.X_FS, handle.bounds.shape);
      }
    }
  }

 private:
  ClaimedGeometry& claims_;
};

}  // namespace

std::string_view NameOf(Claim claim) {
  constexpr std::array<std::string_view, kClaimCount> kNames = {"support", "fitted", "completed",
                                                                "handle", "surface"};
  return kNames[static_cast<std::size_t>(claim)];
}

ClaimedGeometry ClaimsOf(const perception::SceneInterpretation& interpretation) {
  const Pose X_CW = interpretation.X_WC.inverse();
  ClaimedGeometry claims;
  Collector collector(claims);
  for (const perception::DetectedSupport& support : interpretation.supports) {
    const Pose X_CO = X_CW * support.X_WO;
    for (const ShapePart& part : support.model->shapes) {
      collector.AddSolid(Claim::kSupport, X_CO * part.X_OS, part.shape);
    }
    for (const SurfacePart& part : support.model->surfaces) {
      collector.AddMesh(Claim::kSupport, X_CO, part.surface);
    }
  }
  for (const perception::DetectedObject& object : interpretation.objects) {
    collector.AddModel(X_CW * object.X_WO, *object.model);
  }
  return claims;
}

}  // namespace cwm::benchmarks
