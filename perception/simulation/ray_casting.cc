#include "perception/simulation/ray_casting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace cwm::perception {
namespace {

// Collects candidate hits and keeps the nearest in front of the origin.
class NearestHit {
 public:
  explicit NearestHit(const Ray& ray) : ray_(ray) {}

  bool Improves(double t) const { return t > 0 && t < t_; }

  void Offer(double t, const Vector3& normal) {
    if (!Improves(t)) return;
    t_ = t;
    normal_ = normal;
  }

  void Offer(const std::optional<RayHit>& hit) {
    if (hit) Offer(hit->t, hit->normal);
  }

  std::optional<RayHit> Take() const {
    if (!std::isfinite(t_)) return std::nullopt;
    const Vector3 unit = normal_.normalized();
    return RayHit{.t = t_, .normal = unit.dot(ray_.direction) > 0 ? Vector3(-unit) : unit};
  }

 private:
  const Ray& ray_;
  double t_ = std::numeric_limits<double>::infinity();
  Vector3 normal_ = Vector3::UnitZ();
};

// Roots of a t^2 + 2 b t + c in ascending order; the same root twice if the equation is linear;
// empty without real roots.
std::optional<std::array<double, 2>> Roots(double a, double b, double c) {
  if (a == 0) {
    if (b == 0) return std::nullopt;
    return std::array<double, 2>{-0.5 * c / b, -0.5 * c / b};
  }
  const double discriminant = b * b - a * c;
  if (discriminant < 0) return std::nullopt;
  // q has no cancellation; the other root follows from the product c / a.
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  if (q == 0) return std::array<double, 2>{0, 0};
  const double first = q / a;
  const double second = c / q;
  return std::array<double, 2>{std::min(first, second), std::max(first, second)};
}

void OfferDisc(double z, double radius_m, const Ray& ray, NearestHit& nearest) {
  const double t = (z - ray.origin.z()) / ray.direction.z();
  if (!nearest.Improves(t)) return;  // also when t is NaN: a ray in the plane of the disc
  const Vector3 p = ray.origin + t * ray.direction;
  if (p.head<2>().squaredNorm() <= radius_m * radius_m) nearest.Offer(t, Vector3::UnitZ());
}

// The lateral surface x^2 + y^2 = (mid_radius + slope * z)^2 for |z| <= half_length.
struct Lateral {
  double mid_radius_m = 0;
  double slope = 0;
  double half_length_m = 0;
};

void OfferLateral(const Lateral& lateral, const Ray& ray, NearestHit& nearest) {
  const Vector3& o = ray.origin;
  const Vector3& d = ray.direction;
  const double r_o = lateral.mid_radius_m + lateral.slope * o.z();
  const double r_d = lateral.slope * d.z();
  const auto roots =
      Roots(d.head<2>().squaredNorm() - r_d * r_d, o.head<2>().dot(d.head<2>()) - r_o * r_d,
            o.head<2>().squaredNorm() - r_o * r_o);
  if (!roots) return;
  for (const double t : *roots) {
    const Vector3 p = o + t * d;
    const double radius_m = lateral.mid_radius_m + lateral.slope * p.z();
    // A negative radius is the other nappe of the cone.
    if (std::abs(p.z()) > lateral.half_length_m || radius_m < 0) continue;
    nearest.Offer(t, {p.x(), p.y(), -lateral.slope * radius_m});
  }
}

std::array<double, 2> SphereRoots(const Vector3& center, double radius_m, const Ray& ray) {
  const Vector3 o = ray.origin - center;
  const auto roots = Roots(ray.direction.squaredNorm(), o.dot(ray.direction),
                           o.squaredNorm() - radius_m * radius_m);
  return roots.value_or(std::array<double, 2>{-1, -1});
}

void Cast(const Sphere& sphere, const Ray& ray, NearestHit& nearest) {
  for (const double t : SphereRoots(Vector3::Zero(), sphere.radius_m, ray)) {
    nearest.Offer(t, ray.origin + t * ray.direction);
  }
}

void Cast(const Box& box, const Ray& ray, NearestHit& nearest) {
  // Slabs: the ray is inside the box between the last entry and the first exit.
  double t_in = -std::numeric_limits<double>::infinity();
  double t_out = std::numeric_limits<double>::infinity();
  int axis_in = 0;
  int axis_out = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double half_m = 0.5 * box.size_m[axis];
    const double o = ray.origin[axis];
    const double d = ray.direction[axis];
    if (d == 0) {
      if (std::abs(o) > half_m) return;
      continue;
    }
    const double t_low = (std::copysign(half_m, -d) - o) / d;
    const double t_high = (std::copysign(half_m, d) - o) / d;
    if (t_low > t_in) std::tie(t_in, axis_in) = std::pair(t_low, axis);
    if (t_high < t_out) std::tie(t_out, axis_out) = std::pair(t_high, axis);
  }
  if (t_in > t_out) return;
  nearest.Offer(t_in, Vector3::Unit(axis_in));
  nearest.Offer(t_out, Vector3::Unit(axis_out));
}

void CastFrustum(const Lateral& lateral, const Ray& ray, NearestHit& nearest) {
  OfferLateral(lateral, ray, nearest);
  for (const double z : {-lateral.half_length_m, lateral.half_length_m}) {
    OfferDisc(z, lateral.mid_radius_m + lateral.slope * z, ray, nearest);
  }
}

void Cast(const Cylinder& cylinder, const Ray& ray, NearestHit& nearest) {
  CastFrustum({.mid_radius_m = cylinder.radius_m, .half_length_m = 0.5 * cylinder.length_m}, ray,
              nearest);
}

void Cast(const Cone& cone, const Ray& ray, NearestHit& nearest) {
  CastFrustum({.mid_radius_m = 0.5 * (cone.radius_bottom_m + cone.radius_top_m),
               .slope = (cone.radius_top_m - cone.radius_bottom_m) / cone.length_m,
               .half_length_m = 0.5 * cone.length_m},
              ray, nearest);
}

void Cast(const Capsule& capsule, const Ray& ray, NearestHit& nearest) {
  const double half_m = 0.5 * capsule.length_m;
  OfferLateral({.mid_radius_m = capsule.radius_m, .half_length_m = half_m}, ray, nearest);
  for (const double side : {-1.0, 1.0}) {
    const Vector3 center = side * half_m * Vector3::UnitZ();
    for (const double t : SphereRoots(center, capsule.radius_m, ray)) {
      const Vector3 p = ray.origin + t * ray.direction;
      if (side * p.z() >= half_m) nearest.Offer(t, p - center);  // only the outer half is surface
    }
  }
}

void Cast(const HalfSpace&, const Ray& ray, NearestHit& nearest) {
  nearest.Offer(-ray.origin.z() / ray.direction.z(), Vector3::UnitZ());
}

bool OnFace(const Plate& plate, const Vector2& p) {
  if (!Contains(plate.outline, p)) return false;
  return std::none_of(plate.holes.begin(), plate.holes.end(),
                      [&](const Polygon& hole) { return Contains(hole, p); });
}

void CastRim(const Polygon& polygon, double thickness_m, const Ray& ray, NearestHit& nearest) {
  const auto cross = [](const Vector2& a, const Vector2& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  const Vector2 d = ray.direction.head<2>();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2& a = polygon[i];
    const Vector2 edge = polygon[(i + 1) % polygon.size()] - a;
    const Vector2 to_a = a - ray.origin.head<2>();
    const double denominator = cross(d, edge);
    const double t = cross(to_a, edge) / denominator;
    const double along = cross(to_a, d) / denominator;
    if (!nearest.Improves(t) || !(along >= 0 && along <= 1)) continue;
    const double z = ray.origin.z() + t * ray.direction.z();
    if (z <= 0 && z >= -thickness_m) nearest.Offer(t, {edge.y(), -edge.x(), 0});
  }
}

void Cast(const Plate& plate, const Ray& ray, NearestHit& nearest) {
  for (const double z : {0.0, -plate.thickness_m}) {
    const double t = (z - ray.origin.z()) / ray.direction.z();
    if (!nearest.Improves(t)) continue;
    if (OnFace(plate, (ray.origin + t * ray.direction).head<2>())) {
      nearest.Offer(t, Vector3::UnitZ());
    }
  }
  CastRim(plate.outline, plate.thickness_m, ray, nearest);
  for (const Polygon& hole : plate.holes) CastRim(hole, plate.thickness_m, ray, nearest);
}

void Cast(const TriangleMesh& mesh, const Ray& ray, NearestHit& nearest) {
  for (const auto& [a, b, c] : mesh.triangles) {
    nearest.Offer(CastRay(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c], ray));
  }
}

void Cast(const Convex& convex, const Ray& ray, NearestHit& nearest) {
  Cast(*convex.hull, ray, nearest);
}

void Cast(const Mesh& mesh, const Ray& ray, NearestHit& nearest) { Cast(*mesh.mesh, ray, nearest); }

}  // namespace

std::optional<RayHit> CastRay(const Shape& shape, const Ray& ray) {
  NearestHit nearest(ray);
  std::visit([&](const auto& alternative) { Cast(alternative, ray, nearest); }, shape);
  return nearest.Take();
}

// Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
std::optional<RayHit> CastRay(const Vector3& a, const Vector3& b, const Vector3& c,
                              const Ray& ray) {
  const Vector3 ab = b - a;
  const Vector3 ac = c - a;
  const Vector3 h = ray.direction.cross(ac);
  const double determinant = ab.dot(h);
  if (determinant == 0) return std::nullopt;
  const Vector3 s = ray.origin - a;
  const double u = s.dot(h) / determinant;
  if (u < 0 || u > 1) return std::nullopt;
  const Vector3 q = s.cross(ab);
  const double v = ray.direction.dot(q) / determinant;
  if (v < 0 || u + v > 1) return std::nullopt;
  NearestHit nearest(ray);
  nearest.Offer(ac.dot(q) / determinant, ab.cross(ac));
  return nearest.Take();
}

}  // namespace cwm::perception
