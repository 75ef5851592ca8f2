#include "clients/formats/scene_pose.h"

#include <cmath>

namespace cwm::formats {
namespace {

using Vector = std::array<double, 3>;
using Quaternion = std::array<double, 4>;

Vector Cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// Rotates p: p + 2 v x (v x p + w p).
Vector Rotate(const Quaternion& q, const Vector& p) {
  const Vector v = {q[0], q[1], q[2]};
  Vector inner = Cross(v, p);
  for (std::size_t i = 0; i < 3; ++i) inner[i] += q[3] * p[i];
  const Vector turn = Cross(v, inner);
  return {p[0] + 2 * turn[0], p[1] + 2 * turn[1], p[2] + 2 * turn[2]};
}

Quaternion Normalised(Quaternion q) {
  const double length = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  for (double& component : q) component /= length;
  return q;
}

Quaternion Product(const Quaternion& a, const Quaternion& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
          a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
          a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
          a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

}  // namespace

bool IsIdentity(const ScenePose& pose) { return pose == ScenePose{}; }

ScenePose ComposePoses(const ScenePose& x_a_b, const ScenePose& x_b_c) {
  if (IsIdentity(x_a_b)) return x_b_c;
  if (IsIdentity(x_b_c)) return x_a_b;
  ScenePose x_a_c;
  x_a_c.position_m = Rotate(x_a_b.orientation_xyzw, x_b_c.position_m);
  for (std::size_t i = 0; i < 3; ++i) x_a_c.position_m[i] += x_a_b.position_m[i];
  x_a_c.orientation_xyzw = Normalised(Product(x_a_b.orientation_xyzw, x_b_c.orientation_xyzw));
  return x_a_c;
}

ScenePose PlaneFrame(const std::array<double, 4>& abcd) {
  const auto& [a, b, c, d] = abcd;
  const double length = std::hypot(a, b, c);
  const Vector n = {a / length, b / length, c / length};
  ScenePose frame;
  for (std::size_t i = 0; i < 3; ++i) frame.position_m[i] = 0.0 - d / length * n[i];
  // The shortest rotation of z to n is about z x n; straight down, half a turn about x.
  const bool is_down = n[2] < -1 + 1e-12;
  if (is_down) frame.orientation_xyzw = {1, 0, 0, 0};
  if (!is_down) frame.orientation_xyzw = Normalised({-n[1], n[0], 0, 1 + n[2]});
  for (double& q : frame.orientation_xyzw) q += 0.0;  // no -0
  return frame;
}

}  // namespace cwm::formats
