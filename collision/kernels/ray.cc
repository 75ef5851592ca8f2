#include "collision/kernels/ray.h"

#include <array>
#include <cmath>
#include <utility>

#include "collision/geometry/triangle.h"

namespace cwm::collision {
namespace {

// Share of the size by which each face is extended. Without it, rounding could put a hit past the
// border of both faces at an edge and let the ray slip through.
constexpr double kRimShare = 1e-12;

// Collects candidate hits and keeps the first one along the ray.
class FirstHit {
 public:
  explicit FirstHit(const Ray& ray) : ray_(ray) {}

  Vector3 At(double t) const { return ray_.origin + t * ray_.direction; }
  void Offer(double t, const Vector3& normal) {
    if (!(t >= 0) || t > ray_.max_distance_m || (hit_ && t >= hit_->distance_m)) return;
    hit_ = RayHit{t, normal};
  }
  const Ray& ray() const { return ray_; }
  const std::optional<RayHit>& hit() const { return hit_; }

 private:
  const Ray ray_;
  std::optional<RayHit> hit_;
};

// The real roots of a t^2 + 2 b t + c, computed without cancellation.
struct Roots {
  std::array<double, 2> t;
  int count;
};
Roots Solve(double a, double b, double c) {
  if (a == 0) return b == 0 ? Roots{{}, 0} : Roots{{-0.5 * c / b, 0}, 1};
  const double discriminant = b * b - a * c;
  if (discriminant < 0) return {{}, 0};
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  if (q == 0) return {{0, 0}, 1};
  return {{q / a, c / q}, 2};
}

// Offers the hit with the horizontal face at height z, whose normal is (0, 0, up) and whose points
// `contains` accepts.
template <class Contains>
void OfferHorizontal(double z, double up, const Contains& contains, FirstHit& first) {
  if (first.ray().direction.z() == 0) return;
  const double t = (z - first.ray().origin.z()) / first.ray().direction.z();
  if (contains(Vector2(first.At(t).head<2>()))) first.Offer(t, Vector3(0, 0, up));
}

void OfferBall(const Vector3& centre, double radius, double sign_z, FirstHit& first) {
  const Vector3 from = first.ray().origin - centre;
  // Measured from the point of the ray nearest to the centre, so that a distant origin loses no
  // digits.
  const double middle = -from.dot(first.ray().direction);
  const double off_squared = (from + middle * first.ray().direction).squaredNorm();
  const double half_squared = radius * radius - off_squared;
  if (half_squared < 0) return;
  for (const double t : {middle - std::sqrt(half_squared), middle + std::sqrt(half_squared)}) {
    const Vector3 normal = (first.At(t) - centre) / radius;
    if (sign_z * normal.z() >= -kRimShare) first.Offer(t, normal.normalized());
  }
}

// Offers the hits with the slanted side: radius = r0 + slope z for |z| <= half.
void OfferSide(double r0, double slope, double half, FirstHit& first) {
  const Vector3 &o = first.ray().origin, &d = first.ray().direction;
  const double radius = r0 + slope * o.z(), growth = slope * d.z();
  const double a = d.head<2>().squaredNorm() - growth * growth;
  const double b = o.head<2>().dot(d.head<2>()) - radius * growth;
  const double c = o.head<2>().squaredNorm() - radius * radius;
  const Roots roots = Solve(a, b, c);
  for (int i = 0; i < roots.count; ++i) {
    const double t = roots.t[static_cast<std::size_t>(i)];
    const Vector3 p = first.At(t);
    if (std::abs(p.z()) > half * (1 + kRimShare) || r0 + slope * p.z() < 0) continue;
    const double radial = p.head<2>().norm();
    if (!(radial > 0)) continue;  // the apex has no normal
    first.Offer(t, Vector3(p.x() / radial, p.y() / radial, -slope).normalized());
  }
}

struct Caster {
  FirstHit& first;

  void operator()(const Sphere& s) const { OfferBall(Vector3::Zero(), s.radius_m, 0, first); }
  void operator()(const Box& s) const {
    const Vector3 half = 0.5 * s.size_m;
    for (int axis = 0; axis < 3; ++axis) {
      if (first.ray().direction[axis] == 0) continue;
      for (const double sign : {-1.0, 1.0}) {
        const double t =
            (sign * half[axis] - first.ray().origin[axis]) / first.ray().direction[axis];
        Vector3 on_face = first.At(t);
        on_face[axis] = 0;
        const Vector3 room = half + Vector3::Constant(kRimShare * half.maxCoeff());
        if ((on_face.cwiseAbs().array() <= room.array()).all()) {
          first.Offer(t, sign * Vector3::Unit(axis));
        }
      }
    }
  }
  void operator()(const Cylinder& s) const { (*this)(Cone{s.radius_m, s.radius_m, s.length_m}); }
  void operator()(const Cone& s) const {
    const double half = 0.5 * s.length_m;
    const auto disc = [](double radius) {
      return [radius](const Vector2& p) { return p.norm() <= radius * (1 + kRimShare); };
    };
    OfferHorizontal(-half, -1, disc(s.radius_bottom_m), first);
    OfferHorizontal(half, 1, disc(s.radius_top_m), first);
    OfferSide(0.5 * (s.radius_bottom_m + s.radius_top_m),
              (s.radius_top_m - s.radius_bottom_m) / s.length_m, half, first);
  }
  void operator()(const Capsule& s) const {
    const double half = 0.5 * s.length_m;
    OfferBall(Vector3(0, 0, half), s.radius_m, 1, first);
    OfferBall(Vector3(0, 0, -half), s.radius_m, -1, first);
    OfferSide(s.radius_m, 0, half, first);
  }
  void operator()(const HalfSpace&) const {
    OfferHorizontal(
        0, 1, [](const Vector2&) { return true; }, first);
  }
  void operator()(const Plate& s) const {
    const auto solid = [&s](const Vector2& p) {
      if (!Contains(s.outline, p)) return false;
      for (const Polygon& hole : s.holes) {
        if (Contains(hole, p)) return false;
      }
      return true;
    };
    OfferHorizontal(0, 1, solid, first);
    OfferHorizontal(-s.thickness_m, -1, solid, first);
    OfferWalls(s.outline, 1, s.thickness_m);
    for (const Polygon& hole : s.holes) OfferWalls(hole, -1, s.thickness_m);
  }
  void operator()(const Convex& s) const {
    // The interval of the ray inside a polyhedron is the intersection of the intervals behind its
    // planes.
    double enter = -std::numeric_limits<double>::infinity(), leave = -enter;
    Vector3 normal_in = Vector3::UnitZ(), normal_out = Vector3::UnitZ();
    for (const TriangleMesh::Triangle& triangle : s.hull->triangles) {
      const Vector3& a = s.hull->vertices[triangle[0]];
      const std::optional<Vector3> sure_normal =
          ReliableNormal(a, s.hull->vertices[triangle[1]], s.hull->vertices[triangle[2]]);
      if (!sure_normal) continue;
      const Vector3& normal = *sure_normal;
      const double height = normal.dot(first.ray().origin - a);
      const double rate = normal.dot(first.ray().direction);
      if (rate == 0 && height > 0) return;
      if (rate == 0) continue;
      const double t = -height / rate;
      if (rate < 0 && t > enter) std::tie(enter, normal_in) = std::tie(t, normal);
      if (rate > 0 && t < leave) std::tie(leave, normal_out) = std::tie(t, normal);
    }
    if (enter > leave) return;
    first.Offer(enter, normal_in);
    first.Offer(leave, normal_out);
  }
  void operator()(const Mesh&) const {}

 private:
  // Offers the hits with the vertical walls over a ring; `sign` is -1 for a hole.
  void OfferWalls(const Polygon& ring, double sign, double thickness) const {
    const double turn = SignedArea_m2(ring) > 0 ? sign : -sign;
    const Vector2 o = first.ray().origin.head<2>(), d = first.ray().direction.head<2>();
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      const Vector2 along = ring[i] - ring[j];
      const Vector2 outward = turn * Vector2(along.y(), -along.x()).normalized();
      const double rate = outward.dot(d);
      if (rate == 0) continue;
      const double t = outward.dot(ring[j] - o) / rate;
      const double share = (Vector2(o + t * d) - ring[j]).dot(along) / along.squaredNorm();
      const double z = first.At(t).z();
      const double room = kRimShare * thickness;
      if (share < -kRimShare || share > 1 + kRimShare || z > room || z < -thickness - room) {
        continue;
      }
      first.Offer(t, Vector3(outward.x(), outward.y(), 0));
    }
  }

 public:
  explicit Caster(FirstHit& hit) : first(hit) {}
};

}  // namespace

std::optional<RayHit> CastRay(const Shape& shape, const Ray& ray) {
  FirstHit first(ray);
  std::visit(Caster(first), shape);
  return first.hit();
}

}  // namespace cwm::collision
