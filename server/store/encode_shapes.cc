#include "server/store/encode_shapes.h"

#include <memory>
#include <vector>

#include "proto/transfer/mesh_bytes.h"
#include "server/core/geometry_store.h"

namespace cwm::server {
namespace {

void SetPoints(const std::vector<Vector2>& points, store::v1::Polygon* polygon) {
  polygon->mutable_xy_m()->Reserve(2 * static_cast<int>(points.size()));
  for (const Vector2& p : points) {
    polygon->add_xy_m(p.x());
    polygon->add_xy_m(p.y());
  }
}

void SetVector(const Vector3& vector, google::protobuf::RepeatedField<double>* numbers) {
  for (int i = 0; i < 3; ++i) numbers->Add(vector[i]);
}

template <class... Values>
void SetNumbers(store::v1::Numbers* numbers, Values... values) {
  (numbers->add_values(values), ...);
}

// A mesh that is absent has no content.
void SetContent(const std::shared_ptr<const TriangleMesh>& mesh, BlobHashes& blobs,
                store::v1::Mesh* encoded) {
  if (mesh == nullptr) return;
  if (!IsBlob(*mesh)) {
    encoded->set_mesh_f64(EncodeMesh(*mesh));
    return;
  }
  const std::string hash = HashOf(mesh);
  encoded->mutable_blob()->set_sha256(hash);
  encoded->mutable_blob()->set_bytes(EncodedBytes(*mesh));
  blobs.insert(hash);
}

void SetMesh(const Mesh& mesh, BlobHashes& blobs, store::v1::Mesh* encoded) {
  SetContent(mesh.mesh, blobs, encoded);
  encoded->set_watertight(mesh.watertight);
  encoded->set_has_caps(mesh.caps != nullptr);
  if (mesh.caps == nullptr) return;
  for (const MeshCap& cap : *mesh.caps) {
    store::v1::Cap* const added = encoded->add_caps();
    for (const Vector3& end : cap.axis) SetVector(end, added->mutable_axis_m());
    added->set_radius_m(cap.radius_m);
    added->set_diameter_m(cap.diameter_m);
  }
}

class ShapeEncoder {
 public:
  ShapeEncoder(BlobHashes& blobs, store::v1::Shape* encoded) : blobs_(blobs), encoded_(encoded) {}

  void operator()(const Sphere& s) const { encoded_->set_sphere_radius_m(s.radius_m); }
  void operator()(const Box& s) const {
    SetNumbers(encoded_->mutable_box(), s.size_m.x(), s.size_m.y(), s.size_m.z());
  }
  void operator()(const Cylinder& s) const {
    SetNumbers(encoded_->mutable_cylinder(), s.radius_m, s.length_m);
  }
  void operator()(const Cone& s) const {
    SetNumbers(encoded_->mutable_cone(), s.radius_bottom_m, s.radius_top_m, s.length_m);
  }
  void operator()(const Capsule& s) const {
    SetNumbers(encoded_->mutable_capsule(), s.radius_m, s.length_m);
  }
  void operator()(const HalfSpace&) const { encoded_->mutable_half_space(); }
  void operator()(const Plate& s) const {
    store::v1::Plate* const plate = encoded_->mutable_plate();
    SetPoints(s.outline, plate->mutable_outline());
    for (const Polygon& hole : s.holes) SetPoints(hole, plate->add_holes());
    plate->set_thickness_m(s.thickness_m);
  }
  void operator()(const Convex& s) const { SetContent(s.hull, blobs_, encoded_->mutable_convex()); }
  void operator()(const Mesh& s) const { SetMesh(s, blobs_, encoded_->mutable_mesh()); }

 private:
  BlobHashes& blobs_;
  store::v1::Shape* const encoded_;
};

void SetBox(const Placed<Box>& box, store::v1::PlacedBox* encoded) {
  *encoded->mutable_x_fs() = EncodePose(box.X_FS);
  SetVector(box.shape.size_m, encoded->mutable_size_m());
}

void SetFit(const FitQuality& fit, store::v1::FitQuality* encoded) {
  encoded->set_rms_m(fit.rms_m);
  encoded->set_max_residual_m(fit.max_residual_m);
  encoded->set_inlier_count(fit.inlier_count);
  encoded->set_inlier_ratio(fit.inlier_ratio);
  encoded->set_observed_fraction(fit.observed_fraction);
  encoded->mutable_parameter_sigma()->Assign(fit.parameter_sigma.begin(),
                                             fit.parameter_sigma.end());
}

void SetVessel(const VesselShell& shell, store::v1::VesselShell* encoded) {
  SetPoints(shell.outer, encoded->mutable_outer());
  SetPoints(shell.inner, encoded->mutable_inner());
  encoded->set_wall_thickness_m(shell.wall_thickness_m);
  if (shell.rim_radius_sigma_m) encoded->set_rim_radius_sigma_m(*shell.rim_radius_sigma_m);
  if (shell.wall_thickness_sigma_m) {
    encoded->set_wall_thickness_sigma_m(*shell.wall_thickness_sigma_m);
  }
}

}  // namespace

std::int64_t EncodedBytes(const TriangleMesh& mesh) {
  return static_cast<std::int64_t>(kMeshCountsBytes + mesh.vertices.size() * kVertexBytes +
                                   mesh.triangles.size() * kTriangleBytes);
}

store::v1::Pose EncodePose(const Pose& X_AB) {
  store::v1::Pose encoded;
  encoded.mutable_matrix()->Reserve(12);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) encoded.add_matrix(X_AB.matrix()(row, column));
  }
  return encoded;
}

store::v1::Model EncodeModel(const HybridModel& model, BlobHashes& blobs) {
  store::v1::Model encoded;
  for (const ShapePart& part : model.shapes) {
    store::v1::ShapePart* const added = encoded.add_shapes();
    *added->mutable_x_os() = EncodePose(part.X_OS);
    std::visit(ShapeEncoder(blobs, added->mutable_shape()), part.shape);
    added->set_completed(part.role == PartRole::kCompleted);
    if (part.fit) SetFit(*part.fit, added->mutable_fit());
    if (part.vessel != nullptr) SetVessel(*part.vessel, added->mutable_vessel());
    if (part.hidden) SetBox(*part.hidden, added->mutable_hidden());
  }
  for (const SurfacePart& part : model.surfaces) {
    store::v1::SurfacePart* const added = encoded.add_surfaces();
    SetMesh(part.surface, blobs, added->mutable_surface());
    added->set_point_count(part.point_count);
  }
  for (const Handle& handle : model.handles) {
    store::v1::Handle* const added = encoded.add_handles();
    added->set_shape_index(handle.shape_index);
    added->set_point_count(handle.point_count);
    SetVector(handle.axis_O, added->mutable_axis_o());
    SetBox(handle.bounds, added->mutable_bounds());
    SetMesh(handle.surface, blobs, added->mutable_surface());
  }
  encoded.set_point_count(model.point_count);
  return encoded;
}

}  // namespace cwm::server
