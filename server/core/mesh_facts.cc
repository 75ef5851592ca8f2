#include "server/core/mesh_facts.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/geometry/mesh_closing.h"
#include "collision/geometry/validation.h"

namespace cwm::server {
namespace {

MeshHull ComputeHull(const std::shared_ptr<const TriangleMesh>& mesh, WorkCounter* work) {
  // A mesh that is a convex hull already stays as it is, so that its hash stays the same.
  if (!FindViolation(Shape(Convex{mesh}), work)) return {};
  TriangleMesh hull = ConvexHull3(mesh->vertices, work);
  if (hull.triangles.empty()) {
    return {.hull = nullptr, .fault = "names a mesh whose vertices span no volume, must span one"};
  }
  auto shared = std::make_shared<const TriangleMesh>(std::move(hull));
  const auto violation = FindViolation(Shape(Convex{shared}), work);
  if (!violation) return {.hull = std::move(shared), .fault = {}};
  return {.hull = nullptr,
          .fault = absl::StrCat("names a mesh whose hull has ", violation->value, ", ",
                                violation->rule)};
}

}  // namespace

std::optional<Mesh> MeshFacts::SolidOf(const std::shared_ptr<const TriangleMesh>& mesh,
                                       WorkCounter* work) const {
  const Mesh* const known = solid_.Get(
      [&] {
        ++computed_;
        Mesh solid = cwm::SolidOf(mesh, work).value_or(Mesh{});
        if (solid.mesh == mesh) solid.mesh = nullptr;
        return solid;
      },
      work);
  if (known == nullptr) return std::nullopt;
  Mesh solid = *known;
  if (solid.mesh == nullptr) solid.mesh = mesh;
  if (solid.watertight && caps_ != nullptr) solid.caps = caps_;
  return solid;
}

const MeshHull* MeshFacts::HullOf(const std::shared_ptr<const TriangleMesh>& mesh,
                                  WorkCounter* work) const {
  return hull_.Get(
      [&] {
        ++computed_;
        return ComputeHull(mesh, work);
      },
      work);
}

}  // namespace cwm::server
