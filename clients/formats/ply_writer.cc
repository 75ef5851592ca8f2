#include <cstring>

#include "absl/strings/str_cat.h"
#include "clients/formats/ply.h"

namespace cwm::formats {
namespace {

template <class T>
void Append(const T& value, std::string& out) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  out.append(bytes, sizeof(T));
}

}  // namespace

std::string FormatPlyMesh(const MeshFile& mesh) {
  std::string out = absl::StrCat(
      "ply\nformat binary_little_endian 1.0\nelement vertex ", mesh.vertices.size(),
      "\nproperty double x\nproperty double y\nproperty double z\nelement face ",
      mesh.triangles.size(), "\nproperty list uchar uint vertex_indices\nend_header\n");
  out.reserve(out.size() + 24 * mesh.vertices.size() + 13 * mesh.triangles.size());
  for (const auto& vertex : mesh.vertices) Append(vertex, out);
  for (const auto& triangle : mesh.triangles) {
    Append(std::uint8_t{3}, out);
    Append(triangle, out);
  }
  return out;
}

}  // namespace cwm::formats
