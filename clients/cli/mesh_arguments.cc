#include "clients/cli/mesh_arguments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/one_of.h"
#include "clients/cpp/geometry_transfer.h"
#include "clients/formats/format_error.h"
#include "clients/formats/ply.h"
#include "collision/mesh_files/mesh_builder.h"
#include "collision/mesh_files/mesh_file.h"
#include "proto/transfer/mesh_bytes.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using collision::UpAxis;

// A cup of 0.1 m is 100 long in millimetres, a screw of 10 mm is 10; what is longer than this in
// metres is no thing but a building.
constexpr double kLongest_m = 10;

constexpr std::array<std::string_view, 4> kEndings = {".stl", ".obj", ".dae", ".glb"};

std::string EndingOf(std::string_view file) {
  return absl::AsciiStrToLower(std::filesystem::path(file).extension().string());
}

bool IsGlb(std::string_view bytes) { return bytes.starts_with("glTF"); }
bool IsPly(std::string_view bytes) { return bytes.starts_with("ply"); }

// Polygons of a PLY as triangles whose vertices are one where they are at the same place, as the
// other readers have them.
absl::StatusOr<TriangleMesh> ParsePly(std::string_view bytes, const std::string& file) {
  const auto read = formats::ParsePlyMesh(bytes, file);
  if (!read.ok()) return read.status();
  collision::MeshBuilder mesh(collision::MeshFileLimits{}.max_triangles);
  for (const auto& triangle : read->triangles) {
    std::array<Vector3, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) corners[i] = Vector3(read->vertices[triangle[i]].data());
    if (absl::Status status = mesh.Add(corners); !status.ok()) return status;
  }
  return std::move(mesh).Finish();
}

absl::Status In(const std::string& file, const absl::Status& status) {
  const std::string message(status.message());
  if (message.starts_with(file)) return status;
  return absl::Status(status.code(), absl::StrCat(file, ": ", message));
}

// As it stands in the file.
absl::StatusOr<TriangleMesh> ParseAsItStands(std::string_view bytes, const std::string& file) {
  if (IsPly(bytes)) return ParsePly(bytes, file);
  if (IsGlb(bytes)) return collision::ReadMeshFile(bytes, ".glb");
  const std::string ending = EndingOf(file);
  if (std::find(kEndings.begin(), kEndings.end(), ending) == kEndings.end()) {
    return formats::FileError(
        file, {"the ending", ending, "must be .stl, .obj, .dae, .glb or .ply, where it is a mesh"});
  }
  return collision::ReadMeshFile(bytes, ending);
}

absl::StatusOr<UpAxis> UpOf(std::string_view bytes, const std::string& file,
                            const MeshArguments& arguments) {
  if (arguments.up) return *arguments.up;
  if (IsPly(bytes)) return UpAxis::kZ;
  return collision::UpAxisOf(bytes, IsGlb(bytes) ? ".glb" : EndingOf(file));
}

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

bool IsMeshFile(std::string_view bytes, std::string_view file) {
  if (IsPly(bytes)) return formats::HasPlyFaces(bytes);
  const std::string ending = EndingOf(file);
  return IsGlb(bytes) || std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

absl::StatusOr<TriangleMesh> ParseMeshFile(std::string_view bytes, const std::string& file,
                                           const MeshArguments& arguments) {
  if (!(arguments.scale > 0) || !std::isfinite(arguments.scale)) {
    return UsageError(absl::StrCat("--scale is ", arguments.scale, ", must be above 0"));
  }
  auto mesh = ParseAsItStands(bytes, file);
  if (!mesh.ok()) return In(file, mesh.status());
  const auto up = UpOf(bytes, file, arguments);
  if (!up.ok()) return In(file, up.status());
  TriangleMesh standing = collision::WithZUp(*up, *std::move(mesh));
  for (Vector3& p : standing.vertices) {
    p *= arguments.scale;
    if (!p.allFinite()) {
      return In(file, absl::InvalidArgumentError(
                          absl::StrCat("vertices must be finite after --scale ", arguments.scale)));
    }
  }
  return standing;
}

std::optional<std::string> SizeWarning(const TriangleMesh& mesh, const std::string& file) {
  Eigen::AlignedBox3d bounds;
  for (const Vector3& p : mesh.vertices) bounds.extend(p);
  const double longest_m = bounds.sizes().maxCoeff();
  if (!(longest_m > kLongest_m)) return std::nullopt;
  return absl::StrFormat(
      "%s: %.4g m long, coordinates are metres: are these millimetres? --scale 0.001", file,
      longest_m);
}

absl::StatusOr<pb::ShapePart> UploadMesh(Session& session, const TriangleMesh& mesh) {
  const auto hash =
      client::WriteGeometry(session.connection(), {pb::GEOMETRY_FORMAT_MESH_F64, EncodeMesh(mesh)});
  if (!hash.ok()) return hash.status();
  pb::ShapePart part;
  part.mutable_mesh()->set_hash(*hash);
  return part;
}

}  // namespace cwm::cli
