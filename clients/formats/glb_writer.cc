#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/formats/glb.h"
#include "proto/transfer/glb_format.h"
#include "proto/transfer/glb_writer.h"

namespace cwm::formats {
namespace {

using Coordinates = std::array<float, 3>;

std::vector<Coordinates> SinglePrecision(const MeshFile& mesh) {
  std::vector<Coordinates> vertices;
  vertices.reserve(mesh.vertices.size());
  for (const auto& v : mesh.vertices) {
    vertices.push_back({static_cast<float>(v[0]), static_cast<float>(v[1]),  //
                        static_cast<float>(v[2])});
  }
  return vertices;
}

std::string Text(const Coordinates& c) { return absl::StrCat("[", absl::StrJoin(c, ","), "]"); }

// glTF requires the bounds of the accessor of positions.
std::string BoundsText(const std::vector<Coordinates>& vertices) {
  Coordinates min = vertices.front();
  Coordinates max = min;
  for (const Coordinates& vertex : vertices) {
    for (std::size_t i = 0; i < vertex.size(); ++i) {
      min[i] = std::min(min[i], vertex[i]);
      max[i] = std::max(max[i], vertex[i]);
    }
  }
  return absl::StrCat("\"min\":", Text(min), ",\"max\":", Text(max));
}

std::string Describe(const MeshFile& mesh, const std::vector<Coordinates>& vertices) {
  const std::size_t vertex_bytes = vertices.size() * sizeof(Coordinates);
  const std::size_t index_bytes = mesh.triangles.size() * sizeof(mesh.triangles[0]);
  return absl::StrCat(
      R"({"asset":{"version":"2.0","generator":"cwm"},"scene":0,"scenes":[{"nodes":[0]}],)",
      // A rotation by -90 degrees about x: the world's Z becomes glTF's Y.
      R"("nodes":[{"mesh":0,"rotation":[-0.70710678,0,0,0.70710678]}],)",
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)",
      R"("accessors":[{"bufferView":0,"componentType":)", kGltfFloat, R"(,"type":"VEC3","count":)",
      vertices.size(), ",", BoundsText(vertices), R"(},{"bufferView":1,"componentType":)",
      kGltfUnsignedInt, R"(,"type":"SCALAR","count":)", 3 * mesh.triangles.size(),
      R"(}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":)", vertex_bytes,
      R"(,"target":)", kGltfArrayBuffer, R"(},{"buffer":0,"byteOffset":)", vertex_bytes,
      R"(,"byteLength":)", index_bytes, R"(,"target":)", kGltfElementArrayBuffer,
      R"(}],"buffers":[{"byteLength":)", vertex_bytes + index_bytes, "}]}");
}

}  // namespace

std::string FormatGlbMesh(const MeshFile& mesh) {
  const std::vector<Coordinates> vertices = SinglePrecision(mesh);
  std::string binary(reinterpret_cast<const char*>(vertices.data()),
                     vertices.size() * sizeof(Coordinates));
  binary.append(reinterpret_cast<const char*>(mesh.triangles.data()),
                mesh.triangles.size() * sizeof(mesh.triangles[0]));
  return JoinGlb(Describe(mesh, vertices), binary);
}

}  // namespace cwm::formats
