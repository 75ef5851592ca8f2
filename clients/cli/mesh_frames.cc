#include "clients/cli/mesh_frames.h"

namespace cwm::cli {
namespace {

using Triple = std::array<double, 3>;

Triple Cross(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

Triple TransformPoint(const cwm::v1::Pose& x_a_b, const Triple& p_b) {
  const Triple q = {x_a_b.qx(), x_a_b.qy(), x_a_b.qz()};
  const Triple t = {x_a_b.tx_m(), x_a_b.ty_m(), x_a_b.tz_m()};
  // p + 2 q x (q x p + w p) + t
  Triple inner = Cross(q, p_b);
  for (std::size_t i = 0; i < 3; ++i) inner[i] += x_a_b.qw() * p_b[i];
  const Triple turn = Cross(q, inner);
  return {p_b[0] + 2 * turn[0] + t[0], p_b[1] + 2 * turn[1] + t[1], p_b[2] + 2 * turn[2] + t[2]};
}

formats::MeshFile TransformMesh(const cwm::v1::Pose& x_a_b, formats::MeshFile mesh_b) {
  for (Triple& vertex : mesh_b.vertices) vertex = TransformPoint(x_a_b, vertex);
  return mesh_b;
}

}  // namespace cwm::cli
