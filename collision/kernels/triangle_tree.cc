#include "collision/kernels/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "collision/geometry/triangle.h"
#include "collision/geometry/winding.h"

namespace cwm::collision {
namespace {

// Triangles in a leaf: fewer make the tree larger than the mesh, more test triangles in vain.
constexpr std::int32_t kLeafSize = 2;

Vector3 Middle(const TriangleCorners& t) {
  return (t.corners[0] + t.corners[1] + t.corners[2]) / 3.0;
}

// Entry of the ray into the box, or infinity when it misses it.
double EntryIntoBox(const Aabb& box, const Ray& ray) {
  double enter = 0, leave = ray.max_distance_m;
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = ray.origin[axis], direction = ray.direction[axis];
    if (direction == 0) {
      if (origin < box.min()[axis] || origin > box.max()[axis]) {
        return std::numeric_limits<double>::infinity();
      }
      continue;
    }
    const double a = (box.min()[axis] - origin) / direction;
    const double b = (box.max()[axis] - origin) / direction;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  // Rounding of the divisions must not lose a ray in the plane of a flat box.
  return enter <= leave * (1 + 1e-15) + 1e-300 ? enter : std::numeric_limits<double>::infinity();
}

// Where a ray meets a triangle's plane inside of it. The volumes that the ray spans with the edges
// are computed alike for both triangles at an edge, so that no ray slips between them.
struct Crossing {
  double distance_m = 0;
  double clearance = 0;  // smallest barycentric coordinate: how far from the nearest edge
  bool leaves = false;   // the ray runs with the triangle's normal, not against it
};
std::optional<Crossing> Cross(const TriangleCorners& t, const Ray& ray) {
  const Vector3 a = t.corners[0] - ray.origin, b = t.corners[1] - ray.origin,
                c = t.corners[2] - ray.origin;
  const auto edge_volume = [&ray](const Vector3& p, const Vector3& q) {
    return ray.direction.dot(p.cross(q));
  };
  const double u = edge_volume(b, c), v = edge_volume(c, a), w = edge_volume(a, b);
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return std::nullopt;
  const double sum = u + v + w;
  if (sum == 0) return std::nullopt;  // along the plane
  const double distance = (u * a + v * b + w * c).dot(ray.direction) / sum;
  return Crossing{
      distance,
      std::min({u, v, w}, [](double x, double y) { return std::abs(x) < std::abs(y); }) / sum,
      sum > 0};
}

}  // namespace

Vector3 TriangleCorners::Normal() const {
  return TriangleNormal(corners[0], corners[1], corners[2]);
}

double BoxGap_m(const Aabb& a, const Aabb& b) {
  return (a.min() - b.max()).cwiseMax(b.min() - a.max()).cwiseMax(0.0).norm();
}

TriangleTree::TriangleTree(const TriangleMesh& mesh) : component_points_(ComponentPoints(mesh)) {
  triangles_.reserve(mesh.triangles.size());
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    triangles_.push_back({{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}});
  }
  nodes_.reserve(2 * triangles_.size());
  Build(0, static_cast<std::int32_t>(triangles_.size()));
}

// Splits at the median, so that the depth is the logarithm of the count.
std::int32_t TriangleTree::Build(std::int32_t first, std::int32_t count) {
  const auto index = static_cast<std::int32_t>(nodes_.size());
  const std::int32_t all = count;
  nodes_.emplace_back();
  Aabb bounds, middles;
  for (std::int32_t i = first; i < first + count; ++i) {
    for (const Vector3& corner : triangle(i).corners) bounds.extend(corner);
    middles.extend(Middle(triangle(i)));
  }
  std::int32_t right = 0;
  if (count > kLeafSize) {
    Eigen::Index axis;
    middles.sizes().maxCoeff(&axis);
    const auto begin = triangles_.begin() + first;
    std::nth_element(begin, begin + count / 2, begin + count,
                     [axis](const TriangleCorners& a, const TriangleCorners& b) {
                       return Middle(a)[axis] < Middle(b)[axis];
                     });
    Build(first, count / 2);
    right = Build(first + count / 2, count - count / 2);
    count = 0;
  }
  double squared_m2 = 0;
  for (std::int32_t i = first; i < first + all; ++i) {
    for (const Vector3& corner : triangle(i).corners) {
      squared_m2 = std::max(squared_m2, (corner - bounds.center()).squaredNorm());
    }
  }
  nodes_[static_cast<std::size_t>(index)] = {bounds, std::sqrt(squared_m2), right, first, count};
  return index;
}

TriangleTree::Nearest TriangleTree::NearestPoint(const Vector3& p, double max_distance_m,
                                                 WorkCounter* work) const {
  Nearest best{.distance_m = max_distance_m};
  const TriangleCorners* face = nullptr;
  const auto look = [&](const TriangleCorners& t, std::int32_t) {
    const Vector3 q = NearestOnTriangle(t.corners[0], t.corners[1], t.corners[2], p);
    const double distance = (q - p).norm();
    if (distance < best.distance_m) {
      best.distance_m = distance;
      best.point = q;
      face = &t;
    }
    return best.distance_m;
  };
  ForEachNear(Aabb(p, p), max_distance_m, look, work);
  if (face == nullptr) return {};
  best.face_normal = face->Normal();
  return best;
}

TriangleTree::Crossed TriangleTree::FirstCrossed(const Ray& ray, double after_m) const {
  Ray rest = ray;
  Crossed first;
  std::array<std::int32_t, kTreeStack> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::int32_t index = stack[--size];
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (std::isinf(EntryIntoBox(node.bounds, rest))) continue;
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const std::optional<Crossing> crossing = Cross(triangle(i), rest);
      if (!crossing || !(crossing->distance_m > after_m) ||
          crossing->distance_m > rest.max_distance_m) {
        continue;
      }
      first = {&triangle(i), crossing->distance_m, crossing->clearance, crossing->leaves};
      rest.max_distance_m = crossing->distance_m;
    }
    if (node.count > 0) continue;
    const double left = EntryIntoBox(nodes_[static_cast<std::size_t>(index) + 1].bounds, rest);
    const double right = EntryIntoBox(nodes_[static_cast<std::size_t>(node.right)].bounds, rest);
    stack[size++] = left < right ? node.right : index + 1;
    stack[size++] = left < right ? index + 1 : node.right;
  }
  return first;
}

namespace {

// Barycentric clearance below which rounding could put the ray on either side of an edge.
constexpr double kUnsure = 1e-9;
constexpr double kFromOrigin = -std::numeric_limits<double>::denorm_min();

}  // namespace

std::optional<RayHit> TriangleTree::CastRay(const Ray& ray) const {
  const Crossed first = FirstCrossed(ray, kFromOrigin);
  return first.triangle != nullptr ? std::optional(first.Hit()) : std::nullopt;
}

std::optional<RayHit> TriangleTree::CastRayAtSolid(const Ray& ray) const {
  if (!bounds().contains(ray.origin)) return CastRay(ray);  // who comes from outside enters first
  const AllCrossed all = CrossAll(ray.origin, ray.direction);
  const int turns = all.turns ? *all.turns : Winding(ray.origin);
  const bool is_within = all.first.triangle && all.first.distance_m <= ray.max_distance_m;
  Crossed next = all.turns && is_within ? all.first : FirstCrossed(ray, kFromOrigin);
  if (next.triangle == nullptr) return std::nullopt;
  // Whoever is in one part alone leaves that, unless the ray runs along an edge or into another part.
  const int after = turns + (next.leaves ? -1 : 1);
  if (turns == 0 || (after == 0 && next.clearance > kUnsure)) return next.Hit();
  while (next.triangle != nullptr) {
    if (!Buries(ray.origin + next.distance_m * ray.direction, ray.direction)) return next.Hit();
    next = FirstCrossed(ray, next.distance_m);
  }
  return std::nullopt;
}

TriangleTree::AllCrossed TriangleTree::CrossAll(const Vector3& origin,
                                                const Vector3& direction) const {
  const Ray ray{origin, direction};
  Crossed first{.distance_m = std::numeric_limits<double>::infinity()};
  int turns = 0;
  std::array<std::int32_t, kTreeStack> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::int32_t index = stack[--size];
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (std::isinf(EntryIntoBox(node.bounds, ray))) continue;
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const std::optional<Crossing> crossing = Cross(triangle(i), ray);
      if (!crossing) continue;
      if (crossing->clearance < kUnsure) return {};
      const double at_m = crossing->distance_m;
      if (at_m > 0) turns += crossing->leaves ? 1 : -1;
      if (at_m < 0 || at_m >= first.distance_m) continue;
      first = {&triangle(i), at_m, crossing->clearance, crossing->leaves};
    }
    if (node.count > 0) continue;
    stack[size++] = index + 1;
    stack[size++] = node.right;
  }
  return {turns, first};
}

int TriangleTree::Winding(const Vector3& p) const {
  if (!bounds().contains(p)) return 0;
  // Any direction serves; this one is parallel to no face that people or scanners make.
  static const Vector3 kWay = Vector3(0.5257, 0.2874, 0.8006).normalized();
  const AllCrossed all = CrossAll(p, kWay);
  return all.turns ? *all.turns : WindingByAngles(p);
}

int TriangleTree::WindingByAngles(const Vector3& p) const {
  double angle_sr = 0;
  for (const TriangleCorners& t : triangles_) {
    angle_sr += SolidAngle_sr(t.corners[0] - p, t.corners[1] - p, t.corners[2] - p);
  }
  // Of whole turns of 4 pi; half of one is as far from none as from one.
  return static_cast<int>(std::lround(angle_sr / (4.0 * std::numbers::pi)));
}

bool TriangleTree::Buries(const Vector3& p, const Vector3& look) const {
  // Towards corners and faces of a cube, but in no plane that people make: wherever more than a
  // quarter of a turn is open about an edge, one of them is in it.
  static const std::array<Vector3, 7> kWays = {
      Vector3(0.53, 0.62, 0.58),  Vector3(-0.61, 0.55, 0.57), Vector3(0.56, -0.52, 0.64),
      Vector3(0.59, 0.58, -0.56), Vector3(0.99, 0.07, -0.04), Vector3(0.05, 0.99, 0.08),
      Vector3(-0.06, 0.03, 0.99)};
  const auto holds = [&](const Vector3& way) { return Encloses(p + kBuried_m * way); };
  return holds(look.normalized()) && std::all_of(kWays.begin(), kWays.end(), [&](const auto& way) {
           return holds(way.normalized()) && holds(-way.normalized());
         });
}

}  // namespace cwm::collision
