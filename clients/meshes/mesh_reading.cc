#include "clients/meshes/mesh_reading.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/format_error.h"
#include "clients/formats/ply.h"
#include "collision/geometry/validation.h"
#include "collision/mesh_files/mesh_file.h"

namespace cwm::meshes {
namespace {

constexpr std::array<std::string_view, 4> kEndings = {".stl", ".obj", ".dae", ".glb"};

std::string ExtensionOf(std::string_view file) {
  return absl::AsciiStrToLower(std::filesystem::path(file).extension().string());
}
bool HasKnownEnding(std::string_view file) {
  return std::find(kEndings.begin(), kEndings.end(), ExtensionOf(file)) != kEndings.end();
}

bool IsGlb(std::string_view bytes) { return bytes.starts_with("glTF"); }
bool IsPly(std::string_view bytes) { return bytes.starts_with("ply"); }

// Merges vertices at the same place, in the file's order, and drops triangles that collapse.
TriangleMesh WeldVertices(const formats::MeshFile& file) {
  TriangleMesh mesh;
  std::map<std::array<double, 3>, std::uint32_t> index_of;
  std::vector<std::uint32_t> renamed;
  for (const std::array<double, 3>& p : file.vertices) {
    const auto [place, is_new] =
        index_of.try_emplace(p, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (is_new) mesh.vertices.emplace_back(p.data());
    renamed.push_back(place->second);
  }
  for (const auto& [a, b, c] : file.triangles) {
    const TriangleMesh::Triangle corners = {renamed[a], renamed[b], renamed[c]};
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    mesh.triangles.push_back(corners);
  }
  return mesh;
}

absl::StatusOr<TriangleMesh> ParsePly(std::string_view bytes, const std::string& file) {
  const auto read = formats::ParsePlyMesh(bytes, file);
  if (!read.ok()) return read.status();
  constexpr std::size_t kMax = collision::MeshFileLimits{}.max_triangles;
  if (read->triangles.size() > kMax) {
    return absl::ResourceExhaustedError(
        absl::StrCat("has ", read->triangles.size(), " triangles, must have at most ", kMax));
  }
  TriangleMesh mesh = WeldVertices(*read);
  if (const auto violation = FindViolation(mesh)) {
    return formats::FileError(file, {violation->field, violation->value, violation->rule});
  }
  return mesh;
}

absl::Status WithFileName(const std::string& file, const absl::Status& status) {
  const std::string message(status.message());
  if (status.ok() || message.starts_with(file)) return status;
  return absl::Status(status.code(), absl::StrCat(file, ": ", message));
}

absl::StatusOr<UpAxis> UpAxisOf(std::string_view bytes, const std::string& file) {
  if (IsPly(bytes)) return UpAxis::kZ;
  auto up = collision::UpAxisOf(bytes, IsGlb(bytes) ? ".glb" : ExtensionOf(file));
  if (!up.ok()) return WithFileName(file, up.status());
  return up;
}

}  // namespace

bool IsMesh(std::string_view bytes, std::string_view file) {
  if (IsPly(bytes)) return formats::HasPlyFaces(bytes);
  return IsGlb(bytes) || HasKnownEnding(file);
}

absl::StatusOr<TriangleMesh> ParseMesh(std::string_view bytes, const std::string& file) {
  if (!IsPly(bytes) && ExtensionOf(file) == ".ply") {
    return formats::FileError(file, {"the beginning", "another", "must be ply, as of a PLY"});
  }
  if (!IsPly(bytes) && !IsGlb(bytes) && !HasKnownEnding(file)) {
    return formats::FileError(file, {"the ending", ExtensionOf(file),
                                     "must be .stl, .obj, .dae, .glb or .ply, where it is a mesh"});
  }
  auto mesh = IsPly(bytes)
                  ? ParsePly(bytes, file)
                  : collision::ReadMeshFile(bytes, IsGlb(bytes) ? ".glb" : ExtensionOf(file));
  if (!mesh.ok()) return WithFileName(file, mesh.status());
  return mesh;
}

absl::StatusOr<TriangleMesh> ParseUprightMesh(std::string_view bytes, const std::string& file,
                                              std::optional<UpAxis> up) {
  auto mesh = ParseMesh(bytes, file);
  if (!mesh.ok()) return mesh.status();
  const auto axis = up ? absl::StatusOr<UpAxis>(*up) : UpAxisOf(bytes, file);
  if (!axis.ok()) return axis.status();
  return collision::RotateToZUp(*axis, *std::move(mesh));
}

absl::StatusOr<TriangleMesh> ReadMesh(const std::string& path) {
  const auto bytes = formats::ReadFileBytes(path);
  if (!bytes.ok()) return bytes.status();
  return ParseUprightMesh(*bytes, path);
}

}  // namespace cwm::meshes
