#include "collision/engines/fcl_geometry.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/sphere.h>

#include <utility>

#include "collision/engines/convex_pieces.h"

namespace cwm::collision {
namespace {

template <class Geometry>
FclPiece Finished(std::shared_ptr<Geometry> geometry, const Pose& X_SP = Pose::Identity()) {
  geometry->computeLocalAABB();
  return {.geometry = std::move(geometry), .X_SP = X_SP};
}

template <class Geometry, class... Arguments>
FclShape Single(Arguments&&... arguments) {
  return {.pieces = {Finished(std::make_shared<Geometry>(std::forward<Arguments>(arguments)...))}};
}

FclPiece ConvexPiece(const TriangleMesh& hull) {
  auto vertices = std::make_shared<const std::vector<Vector3>>(hull.vertices);
  auto faces = std::make_shared<std::vector<int>>();
  faces->reserve(4 * hull.triangles.size());
  for (const auto& t : hull.triangles) {
    faces->push_back(3);
    for (const std::uint32_t v : t) faces->push_back(static_cast<int>(v));
  }
  return Finished(std::make_shared<fcl::Convexd>(
      std::move(vertices), static_cast<int>(hull.triangles.size()), std::move(faces)));
}

FclShape FromPieces(const ConvexPieceSet& set) {
  FclShape shape{.pieces = {}, .bound_m = set.bound_m};
  for (const TriangleMesh& hull : set.hulls) shape.pieces.push_back(ConvexPiece(hull));
  return shape;
}

struct ToFcl {
  FclShape operator()(const Sphere& s) const { return Single<fcl::Sphered>(s.radius_m); }
  FclShape operator()(const Box& s) const { return Single<fcl::Boxd>(s.size_m); }
  FclShape operator()(const Cylinder& s) const {
    return Single<fcl::Cylinderd>(s.radius_m, s.length_m);
  }
  FclShape operator()(const Cone& s) const {
    if (s.radius_bottom_m == s.radius_top_m) return (*this)(Cylinder{s.radius_top_m, s.length_m});
    if (s.radius_top_m == 0) return Single<fcl::Coned>(s.radius_bottom_m, s.length_m);
    if (s.radius_bottom_m == 0) {
      Pose X_SP = Pose::Identity();  // FCL's apex is up: half a turn about x
      X_SP.linear() = Vector3(1, -1, -1).asDiagonal();
      return {.pieces = {Finished(std::make_shared<fcl::Coned>(s.radius_top_m, s.length_m), X_SP)}};
    }
    return FromPieces(CircumscribedPieces(s));
  }
  FclShape operator()(const Capsule& s) const {
    return Single<fcl::Capsuled>(s.radius_m, s.length_m);
  }
  FclShape operator()(const HalfSpace&) const {
    return Single<fcl::Halfspaced>(Vector3(0, 0, 1), 0.0);  // solid where n . p < d
  }
  FclShape operator()(const Plate& s) const { return FromPieces(CircumscribedPieces(s)); }
  FclShape operator()(const Convex& s) const { return {.pieces = {ConvexPiece(*s.hull)}}; }
  FclShape operator()(const Mesh& s) const {
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(s.mesh->triangles.size());
    for (const auto& t : s.mesh->triangles) triangles.emplace_back(t[0], t[1], t[2]);
    auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
    model->beginModel(static_cast<int>(triangles.size()),
                      static_cast<int>(s.mesh->vertices.size()));
    model->addSubModel(s.mesh->vertices, triangles);
    model->endModel();
    return {.pieces = {Finished(std::move(model))}};
  }
};

}  // namespace

FclShape MakeFclShape(const Shape& shape) { return std::visit(ToFcl{}, shape); }

}  // namespace cwm::collision
