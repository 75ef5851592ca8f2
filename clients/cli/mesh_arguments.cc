#include "clients/cli/mesh_arguments.h"

#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/one_of.h"
#include "clients/cli/progress.h"
#include "clients/cpp/geometry_transfer.h"
#include "clients/meshes/mesh_solid.h"
#include "proto/transfer/mesh_bytes.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using meshes::UpAxis;

// chosen: in millimetres a cup of 0.1 m is 100 long, and a screw of 10 mm is 10; an object longer
// than this in metres would be a building.
constexpr double kMaxPlausibleSize_m = 10;

}  // namespace

void AddMeshOptions(CLI::App& command, const std::string& group, MeshArguments& arguments) {
  static const std::map<std::string, UpAxis> kAxes = {
      {"x", UpAxis::kX}, {"y", UpAxis::kY}, {"z", UpAxis::kZ}};
  command
      .add_option("--scale", arguments.scale, "metres a unit of the mesh: 0.001 for millimetres")
      ->type_name("FACTOR")
      ->group(group);
  command
      .add_option_function<UpAxis>(
          "--up-axis", [&arguments](const UpAxis& up) { arguments.up = up; },
          "the axis of the mesh that is the world's z; default: y for GLB, what a DAE says, else z")
      ->transform(OneOf(kAxes))
      ->type_name("x|y|z")
      ->group(group);
}

absl::StatusOr<TriangleMesh> ParseMeshFile(std::string_view bytes, const std::string& file,
                                           const MeshArguments& arguments) {
  if (!(arguments.scale > 0) || !std::isfinite(arguments.scale)) {
    return UsageError(absl::StrCat("--scale is ", arguments.scale, ", must be above 0"));
  }
  auto mesh = meshes::ParseUprightMesh(bytes, file, arguments.up);
  if (!mesh.ok()) return mesh.status();
  for (Vector3& p : mesh->vertices) {
    p *= arguments.scale;
    if (!p.allFinite()) {
      return absl::InvalidArgumentError(
          absl::StrCat(file, ": vertices must be finite after --scale ", arguments.scale));
    }
  }
  return mesh;
}

std::optional<std::string> SizeWarning(const TriangleMesh& mesh, const std::string& file) {
  Eigen::AlignedBox3d bounds;
  for (const Vector3& p : mesh.vertices) bounds.extend(p);
  const double longest_m = bounds.sizes().maxCoeff();
  if (!(longest_m > kMaxPlausibleSize_m)) return std::nullopt;
  return absl::StrFormat(
      "%s: %.4g m long, coordinates are metres: are these millimetres? --scale 0.001", file,
      longest_m);
}

absl::StatusOr<pb::ShapePart> UploadMesh(Session& session, const TriangleMesh& mesh) {
  Progress progress(session);
  const std::string triangles = absl::StrCat("a mesh of ", mesh.triangles.size(), " triangles");
  const auto hash = client::WriteGeometry(
      session.connection(), {pb::GEOMETRY_FORMAT_MESH_F64, EncodeMesh(mesh)},
      [&](std::int64_t sent, std::int64_t total) {
        if (sent >= total) return progress.ShowStage("the server stores " + triangles);
        progress.Update(
            {.action = "sending", .moved_bytes = sent, .total_bytes = total, .detail = triangles});
      });
  if (!hash.ok()) return hash.status();
  pb::ShapePart part;
  part.mutable_mesh()->set_hash(*hash);
  return part;
}

absl::StatusOr<SentMesh> SendMeshFile(Session& session, std::string_view bytes,
                                      const std::string& file, const MeshArguments& arguments) {
  const auto mesh = ParseMeshFile(bytes, file, arguments);
  if (!mesh.ok()) return mesh.status();
  if (const auto warning = SizeWarning(*mesh, file)) session.Warn(*warning);
  const meshes::MeshSolid solid = meshes::DescribeSolid(*mesh);
  if (solid.is_open) {
    session.Warn(absl::StrCat(file,
                              ": the mesh is open, a surface without an inside: what does not "
                              "touch it is free even within it; close its holes"));
  }
  if (solid.has_caps) {
    session.Warn(absl::StrCat(file, ": the mesh is ", solid.text,
                              ": answers near them are BOUNDED, others as of a solid"));
  }
  auto part = UploadMesh(session, *mesh);
  if (!part.ok()) return part.status();
  const std::size_t count = mesh->triangles.size();
  return SentMesh{.part = *std::move(part),
                  .text = absl::StrCat("a mesh of ", count,
                                       count == 1 ? " triangle, " : " triangles, ", solid.text)};
}

}  // namespace cwm::cli
