// cwm put
#include <memory>

#include "absl/strings/str_cat.h"
#include "clients/cli/body_arguments.h"
#include "clients/cli/change_arguments.h"
#include "clients/cli/commands.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/mesh_arguments.h"
#include "clients/cli/number_list.h"
#include "clients/cli/pose_argument.h"
#include "clients/formats/file_bytes.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

struct PutArguments {
  std::string name, mesh, at = "0,0,0", supported_by;
  ShapeArguments shape;
  MeshArguments mesh_options;
  double margin_m = 0;
  bool unseen = false;
  ChangeArguments change;
};

// The same shape as a part of an object.
pb::ShapePart ToPart(const pb::PlacedShape& shape) {
  pb::ShapePart part;
  if (shape.has_sphere()) *part.mutable_sphere() = shape.sphere();
  if (shape.has_box()) *part.mutable_box() = shape.box();
  if (shape.has_cylinder()) *part.mutable_cylinder() = shape.cylinder();
  if (shape.has_cone()) *part.mutable_cone() = shape.cone();
  if (shape.has_capsule()) *part.mutable_capsule() = shape.capsule();
  return part;
}

// The shape, with words about a mesh.
absl::StatusOr<SentMesh> ReadPart(Session& session, const PutArguments& arguments) {
  if (!arguments.mesh.empty()) {
    if (HasShape(arguments.shape)) return UsageError("--mesh: only one shape at a time");
    const auto bytes = formats::ReadFileBytes(arguments.mesh);
    if (!bytes.ok()) return bytes.status();
    return SendMeshFile(session, *bytes, arguments.mesh, arguments.mesh_options);
  }
  const auto shape = ParseShape(arguments.shape);
  if (!shape.ok()) return shape.status();
  return SentMesh{.part = ToPart(*shape), .text = {}};
}

absl::Status Put(Session& session, const PutArguments& arguments) {
  const auto pose = ParsePoseArgument(session, arguments.at, "--at");
  if (!pose.ok()) return pose.status();
  const auto part = ReadPart(session, arguments);
  if (!part.ok()) return part.status();
  pb::Change change;
  pb::Object& object = *change.mutable_put()->mutable_object();
  object.set_name(arguments.name);
  object.set_kind(arguments.unseen ? pb::OBJECT_KIND_UNSEEN : pb::OBJECT_KIND_USER);
  *object.mutable_x_world_object() = PoseToProto(*pose);
  *object.add_shapes() = part->part;
  object.set_supported_by(arguments.supported_by);
  object.set_margin_m(arguments.margin_m);
  return Apply(session, arguments.change, {change},
               absl::StrCat("put ", arguments.name, part->text.empty() ? "" : ", ", part->text));
}

}  // namespace

void AddPutCommand(CommandLine& line) {
  const auto arguments = std::make_shared<PutArguments>();
  CLI::App& command =
      AddCommand(line,
                 {"put",
                  "an object of yours into the world, or in place of the one of that name",
                  {"cwm put crate --box 0.4,0.3,0.2 --at 0.6,0,0.1",
                   "cwm put post --cylinder 0.03,0.9 --at 1,0,0.45 --margin 0.01",
                   "cwm put statue --mesh statue.stl --scale 0.001 --at 0,1,0"},
                  "What you put is yours: scans neither move nor remove it."},
                 [arguments](Session& session) { return Put(session, *arguments); });
  command.add_option("NAME", arguments->name, "of the object")->required();
  AddShapeOptions(command, arguments->shape);
  command
      .add_option("--mesh", arguments->mesh,
                  "a mesh, solid where watertight: STL, OBJ, PLY, DAE or GLB")
      ->type_name("FILE");
  AddMeshOptions(command, "Meshes", arguments->mesh_options);
  command.add_option("--at", arguments->at, "its pose in the world (m); default: the origin")
      ->type_name(kPoseArgumentForm);
  command.add_option("--margin", arguments->margin_m, "its own collision margin (m)")
      ->type_name("M");
  command.add_option("--supported-by", arguments->supported_by, "what it stands on")
      ->type_name("NAME");
  command.add_flag("--unseen", arguments->unseen,
                   "it is space that no sensor has seen: questions say what that counts as");
  AddChangeOptions(command, arguments->change);
}

}  // namespace cwm::cli
