#include "clients/scene/scene_objects.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"

namespace cwm::scene {
namespace {

namespace pb = cwm::v1;

// Sets the alternative of the part that represents the shape.
struct FillShape {
  pb::ShapePart& part;
  const StoreMesh& store;

  absl::Status operator()(const formats::SceneBox& box) const {
    part.mutable_box()->set_size_x_m(box.size_m[0]);
    part.mutable_box()->set_size_y_m(box.size_m[1]);
    part.mutable_box()->set_size_z_m(box.size_m[2]);
    return absl::OkStatus();
  }
  absl::Status operator()(const formats::SceneSphere& sphere) const {
    part.mutable_sphere()->set_radius_m(sphere.radius_m);
    return absl::OkStatus();
  }
  absl::Status operator()(const formats::SceneCylinder& cylinder) const {
    part.mutable_cylinder()->set_radius_m(cylinder.radius_m);
    part.mutable_cylinder()->set_length_m(cylinder.height_m);
    return absl::OkStatus();
  }
  absl::Status operator()(const formats::SceneCone& cone) const {
    part.mutable_cone()->set_radius_bottom_m(cone.radius_m);
    part.mutable_cone()->set_length_m(cone.height_m);
    return absl::OkStatus();
  }
  absl::Status operator()(const formats::SceneHalfSpace&) const {
    part.mutable_half_space();
    return absl::OkStatus();
  }
  absl::Status operator()(const formats::MeshFile& mesh) const {
    const auto hash = store(mesh);
    if (!hash.ok()) return hash.status();
    part.mutable_mesh()->set_hash(*hash);
    return absl::OkStatus();
  }
};

bool IsNameCharacter(char c) {
  return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
         std::string("_-./").find(c) != std::string::npos;
}

}  // namespace

pb::Pose ScenePoseToProto(const formats::ScenePose& pose) {
  pb::Pose proto;
  proto.set_tx_m(pose.position_m[0]);
  proto.set_ty_m(pose.position_m[1]);
  proto.set_tz_m(pose.position_m[2]);
  proto.set_qx(pose.orientation_xyzw[0]);
  proto.set_qy(pose.orientation_xyzw[1]);
  proto.set_qz(pose.orientation_xyzw[2]);
  proto.set_qw(pose.orientation_xyzw[3]);
  return proto;
}

std::string ObjectName(const std::string& id) {
  std::string name = id;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !IsNameCharacter(c); }, '_');
  return name;
}

absl::StatusOr<pb::Object> ConvertObject(const formats::SceneObject& scene_object,
                                         const StoreMesh& store) {
  pb::Object object;
  object.set_name(ObjectName(scene_object.id));
  object.set_kind(pb::OBJECT_KIND_USER);
  const bool is_its_shape =
      scene_object.shapes.size() == 1 && formats::IsIdentity(scene_object.pose);
  const formats::ScenePose& pose = is_its_shape ? scene_object.shapes[0].pose : scene_object.pose;
  *object.mutable_x_world_object() = ScenePoseToProto(pose);
  for (const formats::SceneShape& shape : scene_object.shapes) {
    pb::ShapePart& part = *object.add_shapes();
    if (!is_its_shape) *part.mutable_x_object_shape() = ScenePoseToProto(shape.pose);
    const absl::Status status = std::visit(FillShape{part, store}, shape.shape);
    if (!status.ok()) {
      return absl::Status(status.code(), absl::StrCat(formats::Printable(scene_object.id), ": ",
                                                      std::string(status.message())));
    }
  }
  return object;
}

}  // namespace cwm::scene
