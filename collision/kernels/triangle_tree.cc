#include "collision/kernels/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "collision/geometry/triangle.h"
#include "collision/geometry/winding.h"

namespace cwm::collision {
namespace {

// chosen: triangles in a leaf. Fewer make the tree larger than the mesh, more test triangles in
// vain.
constexpr std::int32_t kLeafSize = 2;

// Number of triangles whose median is found in one step (a few milliseconds), and number of swaps
// between two calls of the WorkCounter.
constexpr std::int64_t kSelectedAtOnce = std::int64_t{1} << 17;
constexpr std::int64_t kSwappedAtOnce = std::int64_t{1} << 12;
constexpr int kMaxRounds = 64;  // exact halving needs at most 14, from 2^31 to kSelectedAtOnce

Vector3 Middle(const TriangleCorners& t) {
  return (t.corners[0] + t.corners[1] + t.corners[2]) / 3.0;
}

// The distance at which the ray enters the box, or infinity if it misses the box.
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
  // The tolerance keeps rounding of the divisions from losing a ray in the plane of a flat box.
  return enter <= leave * (1 + 1e-15) + 1e-300 ? enter : std::numeric_limits<double>::infinity();
}

// The crossing of a ray's line with a triangle, at any distance. The volumes spanned by the ray and
// an edge are computed in the same way for both triangles at the edge, so that no ray slips between
// them.
struct Crossing {
  double distance_m = 0;
  double clearance = 0;  // smallest barycentric coordinate: distance from the nearest edge
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
  if (sum == 0) return std::nullopt;  // the ray lies in the plane
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

double BoxDistance_m(const Aabb& a, const Aabb& b) {
  return (a.min() - b.max()).cwiseMax(b.min() - a.max()).cwiseMax(0.0).norm();
}

TriangleTree::TriangleTree(const TriangleMesh& mesh, WorkCounter* work)
    : TriangleTree(mesh, ConnectedComponents(mesh, work), {}, work) {}

TriangleTree::TriangleTree(const TriangleMesh& mesh, const std::vector<std::uint32_t>& components,
                           const std::vector<bool>& is_turned, WorkCounter* work) {
  if (HasEnded(work)) return;
  component_points_ = ComponentPoints(mesh, components);
  triangles_.reserve(mesh.triangles.size());
  const bool is_copied =
      ForEachBlock(mesh.triangles.size(), work, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
          const auto& [a, b, c] = mesh.triangles[i];
          triangles_.push_back({{mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]}});
          if (!is_turned.empty() && is_turned[i]) {
            std::swap(triangles_.back().corners[1], triangles_.back().corners[2]);
          }
        }
      });
  if (!is_copied) return;
  nodes_.reserve(2 * triangles_.size());
  Build(0, static_cast<std::int32_t>(triangles_.size()), work);
}

// Splits at the median, so that the depth is logarithmic in the count.
std::int32_t TriangleTree::Build(std::int32_t first, std::int32_t count, WorkCounter* work) {
  const auto index = static_cast<std::int32_t>(nodes_.size());
  const std::int32_t all = count;
  nodes_.emplace_back();
  const auto for_all = [&](const auto& visit) {
    return ForEachBlock(static_cast<std::size_t>(all), work,
                        [&](std::size_t begin, std::size_t end) {
                          for (std::size_t i = begin; i < end; ++i)
                            visit(triangle(first + static_cast<std::int32_t>(i)));
                        });
  };
  Aabb bounds, middles;
  const bool is_bounded = for_all([&](const TriangleCorners& t) {
    for (const Vector3& corner : t.corners) bounds.extend(corner);
    middles.extend(Middle(t));
  });
  if (!is_bounded) return index;
  std::int32_t right = 0;
  if (count > kLeafSize) {
    Eigen::Index axis;
    middles.sizes().maxCoeff(&axis);
    SplitAtMedian(first, count, axis, work);
    Build(first, count / 2, work);
    right = Build(first + count / 2, count - count / 2, work);
    count = 0;
    if (HasEnded(work)) return index;
  }
  double squared_m2 = 0;
  for_all([&](const TriangleCorners& t) {
    for (const Vector3& corner : t.corners) {
      squared_m2 = std::max(squared_m2, (corner - bounds.center()).squaredNorm());
    }
  });
  nodes_[static_cast<std::size_t>(index)] = {bounds, std::sqrt(squared_m2), right, first, count};
  return index;
}

// Quickselect (Hoare 1961), in pieces that `work` can end while there are many triangles.
void TriangleTree::SplitAtMedian(std::int32_t first, std::int32_t count, Eigen::Index axis,
                                 WorkCounter* work) {
  const auto key = [axis](const TriangleCorners& t) { return Middle(t)[axis]; };
  const auto before = [&](const TriangleCorners& a, const TriangleCorners& b) {
    return key(a) < key(b);
  };
  const auto at = [this](std::int64_t i) -> TriangleCorners& {
    return triangles_[static_cast<std::size_t>(i)];
  };
  const std::int64_t middle = first + count / 2;
  std::int64_t low = first, end = first + count;
  // Keys that need too many rounds are left to std::nth_element, whose cost is bounded.
  for (int round = 0; end - low > kSelectedAtOnce && round < kMaxRounds; ++round) {
    std::array<double, 9> keys;  // the median of this sample is near the median of all
    for (std::size_t k = 0; k < keys.size(); ++k) {
      keys[k] = key(at(low + static_cast<std::int64_t>(k) * (end - low - 1) / 8));
    }
    std::nth_element(keys.begin(), keys.begin() + 4, keys.end());
    const double pivot = keys[4];
    std::int64_t i = low - 1, j = end;
    std::int64_t steps = 0;
    while (true) {
      do ++i;
      while (key(at(i)) < pivot);
      do --j;
      while (pivot < key(at(j)));
      if (i >= j) break;
      std::swap(at(i), at(j));
      if (++steps % kSwappedAtOnce == 0 && MustEnd(work, 2 * kSwappedAtOnce)) return;
    }
    if (MustEnd(work, static_cast<std::size_t>((end - low) / 2))) return;
    (middle <= j ? end : low) = j + 1;
  }
  const auto begin = triangles_.begin();
  std::nth_element(begin + low, begin + middle, begin + end, before);
  MustEnd(work, 2 * static_cast<std::size_t>(end - low));
}

// The largest coordinate of a corner along the axis, or the smallest if `sign` is -1.
double TriangleTree::Farthest(const Pose& X_FS, Eigen::Index axis, double sign) const {
  const Vector3 row = sign * X_FS.linear().row(axis).transpose();
  const double origin = sign * X_FS.translation()[axis];
  // Margin far above the rounding error of a bound.
  const double slack = 1e-14 * (std::abs(origin) + bounds().min().cwiseAbs().sum() +
                                bounds().max().cwiseAbs().sum());
  const auto bound = [&](const Node& node) {
    return row.dot(node.bounds.center()) + row.cwiseAbs().dot(0.5 * node.bounds.sizes()) + origin;
  };
  double best = -std::numeric_limits<double>::infinity();
  std::array<std::int32_t, kTreeStackSize> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::int32_t index = stack[--size];
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (bound(node) + slack < best) continue;
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      for (const Vector3& p : triangle(i).corners) {
        best = std::max(best, sign * (X_FS * p)[axis]);
      }
    }
    if (node.count > 0) continue;
    const double left = bound(nodes_[static_cast<std::size_t>(index) + 1]);
    const double right = bound(nodes_[static_cast<std::size_t>(node.right)]);
    stack[size++] = left < right ? index + 1 : node.right;
    stack[size++] = left < right ? node.right : index + 1;
  }
  return sign * best;
}

Aabb TriangleTree::BoundsAt(const Pose& X_FS) const {
  Aabb bounds;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    bounds.min()[axis] = Farthest(X_FS, axis, -1);
    bounds.max()[axis] = Farthest(X_FS, axis, 1);
  }
  return bounds;
}

TriangleTree::Nearest TriangleTree::NearestPoint(const Vector3& p, double max_distance_m,
                                                 WorkCounter* work) const {
  Nearest best{.distance_m = max_distance_m};
  const TriangleCorners* face = nullptr;
  const auto visit = [&](const TriangleCorners& t, std::int32_t) {
    const Vector3 q = NearestOnTriangle(t.corners[0], t.corners[1], t.corners[2], p);
    const double distance = (q - p).norm();
    if (distance < best.distance_m) {
      best.distance_m = distance;
      best.point = q;
      face = &t;
    }
    return best.distance_m;
  };
  ForEachNear(Aabb(p, p), max_distance_m, visit, work);
  if (face == nullptr) return {};
  best.face_normal = face->Normal();
  return best;
}

TriangleTree::RayCrossing TriangleTree::FindFirstCrossing(const Ray& ray, double after_m,
                                                          WorkCounter* work) const {
  Ray rest = ray;
  RayCrossing first;
  std::array<std::int32_t, kTreeStackSize> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::int32_t index = stack[--size];
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (std::isinf(EntryIntoBox(node.bounds, rest))) continue;
    if (MustEnd(work, 1)) break;
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

std::optional<RayHit> TriangleTree::CastRay(const Ray& ray, WorkCounter* work) const {
  const RayCrossing first = FindFirstCrossing(ray, kFromOrigin, work);
  return first.triangle != nullptr ? std::optional(first.Hit()) : std::nullopt;
}

std::optional<RayHit> TriangleTree::CastRayAtSolid(const Ray& ray, WorkCounter* work) const {
  if (!bounds().contains(ray.origin))
    return CastRay(ray, work);  // from outside, the first triangle is an entry
  const RayCrossings all = FindAllCrossings(ray.origin, ray.direction, work);
  const int turns = all.turns ? *all.turns : Winding(ray.origin, work);
  const bool is_within = all.first.triangle && all.first.distance_m <= ray.max_distance_m;
  RayCrossing next = all.turns && is_within ? all.first : FindFirstCrossing(ray, kFromOrigin, work);
  if (next.triangle == nullptr) return std::nullopt;
  // A ray that starts outside enters at the next triangle. One that starts in a single component
  // leaves it there, unless it passes near an edge or enters another component.
  const int after = turns + (next.leaves ? -1 : 1);
  if (turns == 0 || (after == 0 && next.clearance > kUnsure)) return next.Hit();
  while (next.triangle != nullptr && !HasEnded(work)) {
    const Vector3 p = ray.origin + next.distance_m * ray.direction;
    if (!IsInterior(p, ray.direction, work)) return next.Hit();
    next = FindFirstCrossing(ray, next.distance_m, work);
  }
  return std::nullopt;
}

TriangleTree::RayCrossings TriangleTree::FindAllCrossings(const Vector3& origin,
                                                          const Vector3& direction,
                                                          WorkCounter* work) const {
  const Ray ray{origin, direction};
  RayCrossing first{.distance_m = std::numeric_limits<double>::infinity()};
  int turns = 0;
  std::array<std::int32_t, kTreeStackSize> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::int32_t index = stack[--size];
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (std::isinf(EntryIntoBox(node.bounds, ray))) continue;
    if (MustEnd(work, 1)) break;
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

int TriangleTree::Winding(const Vector3& p, WorkCounter* work) const {
  if (!bounds().contains(p)) return 0;
  // Any direction is correct. This one is unlikely to be parallel to a face of a real mesh.
  static const Vector3 kRayDirection = Vector3(0.5257, 0.2874, 0.8006).normalized();
  const RayCrossings all = FindAllCrossings(p, kRayDirection, work);
  return all.turns ? *all.turns : WindingByAngles(p, work);
}

int TriangleTree::WindingByAngles(const Vector3& p, WorkCounter* work) const {
  constexpr std::size_t kStepsPerAngle = 2;
  double angle_sr = 0;
  const auto add = [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const auto& [a, b, c] = triangles_[i].corners;
      angle_sr += SolidAngle_sr(a - p, b - p, c - p);
    }
  };
  ForEachBlock(triangles_.size(), work, add, kStepsPerAngle);
  // The exact angle is a multiple of 4 pi; lround takes the nearest.
  return static_cast<int>(std::lround(angle_sr / (4.0 * std::numbers::pi)));
}

bool TriangleTree::IsInterior(const Vector3& p, const Vector3& first_direction,
                              WorkCounter* work) const {
  // Directions near the corners and faces of a cube, but off the planes of typical meshes. If more
  // than a quarter turn about an edge is outside the solid, one of them points into it.
  static const std::array<Vector3, 7> kRayDirections = {
      Vector3(0.53, 0.62, 0.58),  Vector3(-0.61, 0.55, 0.57), Vector3(0.56, -0.52, 0.64),
      Vector3(0.59, 0.58, -0.56), Vector3(0.99, 0.07, -0.04), Vector3(0.05, 0.99, 0.08),
      Vector3(-0.06, 0.03, 0.99)};
  const auto holds = [&](const Vector3& way) {
    return Contains(p + kInteriorTolerance_m * way, work);
  };
  return holds(first_direction.normalized()) &&
         std::all_of(kRayDirections.begin(), kRayDirections.end(), [&](const auto& way) {
           return holds(way.normalized()) && holds(-way.normalized());
         });
}

}  // namespace cwm::collision
