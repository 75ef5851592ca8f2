#include "collision/geometry/winding.h"

#include <cmath>
#include <numbers>

namespace cwm {

double SolidAngle_sr(const Vector3& a, const Vector3& b, const Vector3& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double numerator = a.dot(b.cross(c));
  const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2.0 * std::atan2(numerator, denominator);
}

double WindingNumber(const TriangleMesh& mesh, const Vector3& p) {
  double angle_sr = 0;
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    angle_sr +=
        SolidAngle_sr(mesh.vertices[t[0]] - p, mesh.vertices[t[1]] - p, mesh.vertices[t[2]] - p);
  }
  return angle_sr / (4.0 * std::numbers::pi);
}

}  // namespace cwm
