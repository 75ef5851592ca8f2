#include "clients/simulator/mesh_reading.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <map>

#include "clients/formats/file_bytes.h"
#include "clients/formats/format_error.h"
#include "clients/formats/ply.h"
#include "clients/simulator/mesh_formats.h"
#include "collision/geometry/validation.h"

namespace cwm::simulator {
namespace {

TriangleMesh FromFile(const formats::MeshFile& file) {
  TriangleMesh mesh;
  for (const auto& [x, y, z] : file.vertices) mesh.vertices.emplace_back(x, y, z);
  mesh.triangles = file.triangles;
  return mesh;
}

// STL repeats a vertex in each of its triangles. Triangles that collapse are left out.
TriangleMesh Welded(const TriangleMesh& mesh) {
  TriangleMesh welded;
  std::map<std::array<double, 3>, std::uint32_t> index_of;
  std::vector<std::uint32_t> renamed;
  for (const Vector3& p : mesh.vertices) {
    const auto [place, is_new] = index_of.try_emplace(
        {p.x(), p.y(), p.z()}, static_cast<std::uint32_t>(welded.vertices.size()));
    if (is_new) welded.vertices.push_back(p);
    renamed.push_back(place->second);
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    const TriangleMesh::Triangle triangle = {renamed[a], renamed[b], renamed[c]};
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) {
      continue;
    }
    welded.triangles.push_back(triangle);
  }
  return welded;
}

absl::StatusOr<formats::MeshFile> Parse(const std::string& path, const std::string& bytes,
                                        const std::string& ending) {
  if (ending == ".stl") return ParseStl(bytes, path);
  if (ending == ".obj") return ParseObj(bytes, path);
  return formats::ParsePlyMesh(bytes, path);
}

}  // namespace

absl::StatusOr<TriangleMesh> ReadMesh(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending != ".ply" && ending != ".stl" && ending != ".obj") {
    return formats::FileError(
        path, {.field = "the ending", .value = ending, .rule = "must be .ply, .stl or .obj"});
  }
  const auto bytes = formats::ReadFileBytes(path);
  if (!bytes.ok()) return bytes.status();
  const auto file = Parse(path, *bytes, ending);
  if (!file.ok()) return file.status();
  TriangleMesh welded = Welded(FromFile(*file));
  if (const auto violation = FindViolation(welded)) {
    return formats::FileError(
        path, {.field = violation->field, .value = violation->value, .rule = violation->rule});
  }
  return welded;
}

}  // namespace cwm::simulator
