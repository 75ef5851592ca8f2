#include "clients/cli/mesh_frames.h"

namespace cwm::cli {
namespace {

using Vector = std::array<double, 3>;

Vector Cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

Vector Transformed(const cwm::v1::Pose& x_a_b, const Vector& p_b) {
  const Vector q = {x_a_b.qx(), x_a_b.qy(), x_a_b.qz()};
  const Vector t = {x_a_b.tx_m(), x_a_b.ty_m(), x_a_b.tz_m()};
  // p + 2 q x (q x p + w p) + t
  Vector inner = Cross(q, p_b);
  for (std::size_t i = 0; i < 3; ++i) inner[i] += x_a_b.qw() * p_b[i];
  const Vector turn = Cross(q, inner);
  return {p_b[0] + 2 * turn[0] + t[0], p_b[1] + 2 * turn[1] + t[1], p_b[2] + 2 * turn[2] + t[2]};
}

formats::MeshFile Transformed(const cwm::v1::Pose& x_a_b, formats::MeshFile mesh_b) {
  for (Vector& vertex : mesh_b.vertices) vertex = Transformed(x_a_b, vertex);
  return mesh_b;
}

}  // namespace cwm::cli
