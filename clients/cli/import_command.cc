// cwm import
#include <memory>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "clients/cli/change_arguments.h"
#include "clients/cli/commands.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/scene_file.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using formats::SceneBox;
using formats::SceneCone;
using formats::SceneCylinder;
using formats::SceneObject;
using formats::ScenePose;
using formats::ScenePrimitive;
using formats::SceneSphere;

// A planning scene is text of some kilobytes; this is a mesh-laden one many times over.
constexpr std::int64_t kMaxSceneBytes = 64 << 20;

struct ImportArguments {
  std::string file;
  ChangeArguments change;
};

pb::Pose ToProto(const ScenePose& pose) {
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

// Fills in the alternative of the part that stands for the primitive.
struct FillShape {
  pb::ShapePart& part;

  void operator()(const SceneBox& box) const {
    part.mutable_box()->set_size_x_m(box.size_m[0]);
    part.mutable_box()->set_size_y_m(box.size_m[1]);
    part.mutable_box()->set_size_z_m(box.size_m[2]);
  }
  void operator()(const SceneSphere& sphere) const {
    part.mutable_sphere()->set_radius_m(sphere.radius_m);
  }
  void operator()(const SceneCylinder& cylinder) const {
    part.mutable_cylinder()->set_radius_m(cylinder.radius_m);
    part.mutable_cylinder()->set_length_m(cylinder.height_m);
  }
  void operator()(const SceneCone& cone) const {
    part.mutable_cone()->set_radius_bottom_m(cone.radius_m);
    part.mutable_cone()->set_length_m(cone.height_m);
  }
};

bool IsIdentity(const ScenePose& pose) {
  const ScenePose identity;
  return pose.position_m == identity.position_m &&
         pose.orientation_xyzw == identity.orientation_xyzw;
}

pb::Change ToChange(const SceneObject& scene_object) {
  pb::Change change;
  pb::Object& object = *change.mutable_put()->mutable_object();
  object.set_name(scene_object.id);
  object.set_kind(pb::OBJECT_KIND_USER);
  *object.mutable_x_world_object() = ToProto(scene_object.pose);
  // An object of one primitive without a pose of its own gets the primitive's, so that moving it
  // does what one expects.
  if (scene_object.primitives.size() == 1 && IsIdentity(scene_object.pose)) {
    *object.mutable_x_world_object() = ToProto(scene_object.primitives[0].pose);
    std::visit(FillShape{*object.add_shapes()}, scene_object.primitives[0].shape);
    return change;
  }
  for (const ScenePrimitive& primitive : scene_object.primitives) {
    pb::ShapePart& part = *object.add_shapes();
    *part.mutable_x_object_shape() = ToProto(primitive.pose);
    std::visit(FillShape{part}, primitive.shape);
  }
  return change;
}

absl::Status Import(Session& session, const ImportArguments& arguments) {
  const auto yaml = formats::ReadFileBytes(arguments.file, kMaxSceneBytes);
  if (!yaml.ok()) return yaml.status();
  const auto scene = formats::ParseScene(*yaml, arguments.file);
  if (!scene.ok()) return scene.status();
  for (const std::string& warning : scene->warnings) session.Warn(warning);
  if (scene->objects.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(arguments.file, ": holds no object to import"));
  }
  std::vector<pb::Change> changes;
  for (const SceneObject& object : scene->objects) changes.push_back(ToChange(object));
  return Apply(session, arguments.change, changes,
               absl::StrCat("imported ", changes.size(), " objects"));
}

}  // namespace

void AddImportCommand(CommandLine& line) {
  const auto arguments = std::make_shared<ImportArguments>();
  CLI::App& command =
      AddCommand(line,
                 {"import",
                  "the objects of a MoveIt planning scene (YAML), in one revision",
                  {"cwm import scene0001.yaml", "cwm import scene0001.yaml --world shelf"},
                  "Boxes, cylinders, spheres and cones are put under their ids; meshes are left "
                  "out with a warning."},
                 [arguments](Session& session) { return Import(session, *arguments); });
  command.add_option("SCENE", arguments->file, "a YAML file")->required();
  AddChangeOptions(command, arguments->change);
}

}  // namespace cwm::cli
