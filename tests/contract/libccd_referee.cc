#include "tests/contract/libccd_referee.h"

#include <ccd/ccd.h>

#include <cmath>
#include <variant>

#include "collision/geometry/support.h"

namespace cwm::collision {
namespace {

struct SupportOf {
  Vector3 d;
  Vector3 operator()(const Sphere& s) const { return s.radius_m * d.normalized(); }
  Vector3 operator()(const Box& s) const { return SupportPoint(s, d); }
  Vector3 operator()(const Cylinder& s) const { return SupportPoint(s, d); }
  Vector3 operator()(const Cone& s) const { return SupportPoint(s, d); }
  Vector3 operator()(const Capsule& s) const {
    return Vector3(0, 0, std::copysign(s.length_m / 2, d.z())) + s.radius_m * d.normalized();
  }
  Vector3 operator()(const Convex& s) const { return SupportPoint(s.hull->vertices, d); }
  Vector3 operator()(const HalfSpace&) const { return Vector3::Zero(); }
  Vector3 operator()(const Plate& s) const {
    Vector2 farthest = s.outline.front();
    for (const Vector2& p : s.outline) {
      if (d.head<2>().dot(p) > d.head<2>().dot(farthest)) farthest = p;
    }
    return {farthest.x(), farthest.y(), d.z() < 0 ? -s.thickness_m : 0};
  }
  Vector3 operator()(const Mesh&) const { return Vector3::Zero(); }
};

void Support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
  const LibccdBody& body = *static_cast<const LibccdBody*>(object);
  const Vector3 d_W(direction->v[0], direction->v[1], direction->v[2]);
  const Vector3 p =
      body.X_WS * std::visit(SupportOf{body.X_WS.linear().transpose() * d_W}, body.shape);
  ccdVec3Set(point, p.x(), p.y(), p.z());
}

}  // namespace

bool IsKnownToLibccd(const Shape& shape) {
  if (const auto* plate = std::get_if<Plate>(&shape)) return plate->holes.empty();
  return !std::holds_alternative<HalfSpace>(shape) && !std::holds_alternative<Mesh>(shape);
}

std::optional<LibccdDepth> LibccdPenetration(const LibccdBody& a, const LibccdBody& b) {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd.support2 = Support;
  ccd.max_iterations = 500;
  ccd.epa_tolerance = kEpaTolerance_m;
  ccd_real_t depth = 0;
  ccd_vec3_t direction, point;
  if (ccdGJKPenetration(&a, &b, &ccd, &depth, &direction, &point) != 0) return std::nullopt;
  const Vector3 d(direction.v[0], direction.v[1], direction.v[2]);
  if (!(std::abs(d.norm() - 1) < 1e-6)) return std::nullopt;
  return LibccdDepth{depth, d};
}

}  // namespace cwm::collision
