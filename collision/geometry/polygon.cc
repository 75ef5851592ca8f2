#include "collision/geometry/polygon.h"

#include <algorithm>
#include <limits>

#include "collision/geometry/segment.h"

namespace cwm {
namespace {

// Twice the signed area of (a, b, c), in extended precision so that coordinates of 1e6 m still
// resolve nanometres.
long double Orientation(const Vector2& a, const Vector2& b, const Vector2& c) {
  const long double abx = static_cast<long double>(b.x()) - a.x();
  const long double aby = static_cast<long double>(b.y()) - a.y();
  const long double acx = static_cast<long double>(c.x()) - a.x();
  const long double acy = static_cast<long double>(c.y()) - a.y();
  return abx * acy - aby * acx;
}

bool InBounds(const Vector2& a, const Vector2& b, const Vector2& p) {
  return (p.array() >= a.cwiseMin(b).array()).all() && (p.array() <= a.cwiseMax(b).array()).all();
}

struct Edge {
  Vector2 a, b;
  int ring, index, ring_size;
  double min_x() const { return std::min(a.x(), b.x()); }
  double max_x() const { return std::max(a.x(), b.x()); }
};

bool SegmentsTouch(const Edge& e, const Edge& f) {
  if (std::max(e.a.y(), e.b.y()) < std::min(f.a.y(), f.b.y()) ||
      std::max(f.a.y(), f.b.y()) < std::min(e.a.y(), e.b.y())) {
    return false;
  }
  const long double fa = Orientation(e.a, e.b, f.a), fb = Orientation(e.a, e.b, f.b);
  const long double ea = Orientation(f.a, f.b, e.a), eb = Orientation(f.a, f.b, e.b);
  if (((fa > 0 && fb < 0) || (fa < 0 && fb > 0)) && ((ea > 0 && eb < 0) || (ea < 0 && eb > 0))) {
    return true;
  }
  return (fa == 0 && InBounds(e.a, e.b, f.a)) || (fb == 0 && InBounds(e.a, e.b, f.b)) ||
         (ea == 0 && InBounds(f.a, f.b, e.a)) || (eb == 0 && InBounds(f.a, f.b, e.b));
}

// Two consecutive edges a-b and b-c conflict only when c folds back onto a-b.
bool FoldsBack(const Edge& first, const Edge& second) {
  return Orientation(first.a, first.b, second.b) == 0 &&
         (first.b - first.a).dot(second.b - second.a) < 0;
}

bool Conflict(const Edge& e, const Edge& f) {
  if (e.ring == f.ring) {
    if ((e.index + 1) % e.ring_size == f.index) return FoldsBack(e, f);
    if ((f.index + 1) % f.ring_size == e.index) return FoldsBack(f, e);
  }
  return SegmentsTouch(e, f);
}

// Appends the edges of a ring; false when one has no length or the ring is no polygon.
bool AppendEdges(const Polygon& polygon, int ring, std::vector<Edge>& edges) {
  const int size = static_cast<int>(polygon.size());
  if (size < 3) return false;
  for (int i = 0; i < size; ++i) {
    edges.push_back({polygon[i], polygon[(i + 1) % size], ring, i, size});
    if (!edges.back().a.allFinite() || edges.back().a == edges.back().b) return false;
  }
  return true;
}

// Sweep over x: an edge is compared only with those whose x intervals overlap its own.
bool HasConflict(std::vector<Edge>& edges) {
  std::sort(edges.begin(), edges.end(),
            [](const Edge& e, const Edge& f) { return e.min_x() < f.min_x(); });
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = i + 1; j < edges.size() && edges[j].min_x() <= edges[i].max_x(); ++j) {
      if (Conflict(edges[i], edges[j])) return true;
    }
  }
  return false;
}

}  // namespace

double SignedArea_m2(const Polygon& polygon) {
  double twice_area = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const Vector2 u = polygon[i - 1] - polygon[0], v = polygon[i] - polygon[0];
    twice_area += u.x() * v.y() - u.y() * v.x();
  }
  return 0.5 * twice_area;
}

bool Contains(const Polygon& polygon, const Vector2& point) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vector2 &a = polygon[j], &b = polygon[i];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    const double x = a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (point.x() < x) inside = !inside;
  }
  return inside;
}

Vector2 NearestOnBorder(const Polygon& polygon, const Vector2& point) {
  Vector2 best = polygon.front();
  double best_squared = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vector2 candidate = NearestOnSegment(polygon[j], polygon[i], point);
    const double squared = (candidate - point).squaredNorm();
    if (squared < best_squared) {
      best_squared = squared;
      best = candidate;
    }
  }
  return best;
}

bool IsSimple(const Polygon& polygon) { return IsSimpleRegion(polygon, {}); }

bool IsSimpleRegion(const Polygon& outline, const std::vector<Polygon>& holes) {
  std::vector<Edge> edges;
  if (!AppendEdges(outline, 0, edges)) return false;
  for (std::size_t i = 0; i < holes.size(); ++i) {
    if (!AppendEdges(holes[i], static_cast<int>(i) + 1, edges)) return false;
  }
  if (HasConflict(edges)) return false;
  // Borders do not touch, so one vertex of a hole decides for the whole hole.
  for (std::size_t i = 0; i < holes.size(); ++i) {
    if (!Contains(outline, holes[i].front())) return false;
    for (std::size_t j = 0; j < holes.size(); ++j) {
      if (j != i && Contains(holes[j], holes[i].front())) return false;
    }
  }
  return true;
}

Polygon ConvexHull(std::vector<Vector2> points) {
  std::sort(points.begin(), points.end(), [](const Vector2& a, const Vector2& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  Polygon hull;
  const auto extend = [&hull](const Vector2& p, std::size_t floor) {
    while (hull.size() >= floor + 2 &&
           Orientation(hull[hull.size() - 2], hull[hull.size() - 1], p) <= 0) {
      hull.pop_back();
    }
    hull.push_back(p);
  };
  for (const Vector2& p : points) extend(p, 0);
  const std::size_t lower = hull.size() - 1;
  for (auto p = points.rbegin() + 1; p != points.rend(); ++p) extend(*p, lower);
  hull.pop_back();  // the first point again
  return hull;
}

}  // namespace cwm
