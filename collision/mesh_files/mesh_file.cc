#include "collision/mesh_files/mesh_file.h"

#include <array>
#include <string>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "collision/mesh_files/collada_file.h"
#include "collision/mesh_files/glb_file.h"
#include "collision/mesh_files/mesh_builder.h"
#include "collision/mesh_files/obj_file.h"
#include "collision/mesh_files/stl_file.h"

namespace cwm::collision {
namespace {

struct Format {
  std::string_view ending;
  absl::StatusOr<TriangleMesh> (*read)(std::string_view, const MeshFileLimits&);
};
constexpr std::array<Format, 4> kFormats = {
    {{".stl", ReadStl}, {".obj", ReadObj}, {".dae", ReadCollada}, {".glb", ReadGlb}}};

// Reads a mesh with at most as many triangles as a file of that size may have.
absl::StatusOr<TriangleMesh> ReadBounded(const Format& format, std::string_view bytes,
                                         const MeshFileLimits& limits) {
  MeshFileLimits bounded = limits;
  bounded.max_triangles = limits.MaxTrianglesOf(bytes.size());
  absl::StatusOr<TriangleMesh> mesh = format.read(bytes, bounded);
  if (bounded.max_triangles == limits.max_triangles ||
      mesh.status() != TooManyTriangles(bounded.max_triangles)) {
    return mesh;
  }
  return absl::ResourceExhaustedError(absl::StrCat(
      std::string(mesh.status().message()), ": ", limits.max_free_triangles, " and one for each ",
      limits.min_bytes_per_triangle, " of its ", bytes.size(), " bytes"));
}

}  // namespace

absl::StatusOr<TriangleMesh> ReadMeshFile(std::string_view bytes, std::string_view name,
                                          const MeshFileLimits& limits) {
  const std::string lower = absl::AsciiStrToLower(std::string(name));
  for (const Format& format : kFormats) {
    if (!std::string_view(lower).ends_with(format.ending)) continue;
    if (bytes.empty()) return absl::InvalidArgumentError("must not be empty");
    if (bytes.size() <= limits.max_bytes) return ReadBounded(format, bytes, limits);
    return absl::ResourceExhaustedError(
        absl::StrCat("is ", bytes.size(), " bytes long, must be at most ", limits.max_bytes));
  }
  return absl::InvalidArgumentError("must end in .stl, .obj, .dae or .glb");
}

absl::StatusOr<UpAxis> UpAxisOf(std::string_view bytes, std::string_view name,
                                const MeshFileLimits& limits) {
  const std::string lower = absl::AsciiStrToLower(std::string(name));
  if (std::string_view(lower).ends_with(".glb")) return UpAxis::kY;
  if (std::string_view(lower).ends_with(".dae")) return ColladaUpAxis(bytes, limits);
  return UpAxis::kZ;
}

TriangleMesh RotateToZUp(UpAxis up, TriangleMesh mesh) {
  for (Vector3& p : mesh.vertices) {
    if (up == UpAxis::kX) p = Vector3(-p.y(), -p.z(), p.x());
    if (up == UpAxis::kY) p = Vector3(p.x(), -p.z(), p.y());
  }
  return mesh;
}

}  // namespace cwm::collision
