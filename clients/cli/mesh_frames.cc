#include "clients/cli/mesh_frames.h"

namespace cwm::cli {
namespace {

using Vector = std::array<double, 3>;

Vector Cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

formats::MeshFile Transformed(const cwm::v1::Pose& x_a_b, formats::MeshFile mesh_b) {
  const Vector q = {x_a_b.qx(), x_a_b.qy(), x_a_b.qz()};
  const Vector t = {x_a_b.tx_m(), x_a_b.ty_m(), x_a_b.tz_m()};
  for (Vector& vertex : mesh_b.vertices) {
    // v + 2 q x (q x v + w v)
    Vector inner = Cross(q, vertex);
    for (int i = 0; i < 3; ++i) inner[i] += x_a_b.qw() * vertex[i];
    const Vector turn = Cross(q, inner);
    for (int i = 0; i < 3; ++i) vertex[i] += 2 * turn[i] + t[i];
  }
  return mesh_b;
}

void Append(const formats::MeshFile& more, formats::MeshFile& mesh) {
  const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const auto& triangle : more.triangles) {
    mesh.triangles.push_back({triangle[0] + offset, triangle[1] + offset, triangle[2] + offset});
  }
}

}  // namespace cwm::cli
