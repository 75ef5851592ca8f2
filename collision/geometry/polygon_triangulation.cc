// Ear clipping with bridged holes, and convex pieces by merging triangles.
#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "collision/geometry/polygon.h"

namespace cwm {
namespace {

using IndexTriangle = std::array<int, 3>;
using Ring = std::vector<int>;  // indices of vertices; a bridge makes an index appear twice

double Cross(const Vector2& a, const Vector2& b, const Vector2& c) {
  const Vector2 u = b - a, v = c - a;
  return u.x() * v.y() - u.y() * v.x();
}

bool InClosedTriangle(const Vector2& a, const Vector2& b, const Vector2& c, const Vector2& p) {
  return Cross(a, b, p) >= 0 && Cross(b, c, p) >= 0 && Cross(c, a, p) >= 0;
}

// True when segment a-b meets segment c-d anywhere but at a common end point.
bool Blocks(const Vector2& a, const Vector2& b, const Vector2& c, const Vector2& d) {
  const double abc = Cross(a, b, c), abd = Cross(a, b, d);
  const double cda = Cross(c, d, a), cdb = Cross(c, d, b);
  const auto between = [](const Vector2& p, const Vector2& q, const Vector2& x) {
    return x != p && x != q && (x - p).dot(x - q) < 0;
  };
  if (abc == 0 && between(a, b, c)) return true;
  if (abd == 0 && between(a, b, d)) return true;
  return ((abc > 0) != (abd > 0)) && abc != 0 && abd != 0 && ((cda > 0) != (cdb > 0)) && cda != 0 &&
         cdb != 0;
}

class EarClipper {
 public:
  EarClipper(const Polygon& outline, const std::vector<Polygon>& holes) {
    ring_ = AppendRing(outline, /*counter_clockwise=*/true);
    for (const Polygon& hole : holes) {
      holes_.push_back(AppendRing(hole, /*counter_clockwise=*/false));
    }
  }

  std::vector<IndexTriangle> Run() {
    while (!holes_.empty()) BridgeNextHole();
    std::vector<IndexTriangle> triangles;
    std::size_t at = 0;
    while (ring_.size() > 3) {
      at = FindEar(at);
      const std::size_t n = ring_.size();
      triangles.push_back({ring_[(at + n - 1) % n], ring_[at], ring_[(at + 1) % n]});
      ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(at));
      if (at > 0) --at;
    }
    triangles.push_back({ring_[0], ring_[1], ring_[2]});
    return triangles;
  }

  const std::vector<Vector2>& vertices() const { return vertices_; }

 private:
  Ring AppendRing(const Polygon& polygon, bool counter_clockwise) {
    Ring ring(polygon.size());
    std::iota(ring.begin(), ring.end(), static_cast<int>(vertices_.size()));
    vertices_.insert(vertices_.end(), polygon.begin(), polygon.end());
    if ((SignedArea_m2(polygon) > 0) != counter_clockwise) std::reverse(ring.begin(), ring.end());
    return ring;
  }

  const Vector2& V(int index) const { return vertices_[static_cast<std::size_t>(index)]; }
  const Vector2& At(std::size_t position) const { return V(ring_[position % ring_.size()]); }

  // Joins the hole that reaches farthest to +x: nothing but the outer ring lies beyond it, so some
  // vertex of that ring is visible from its rightmost vertex.
  void BridgeNextHole() {
    const auto rightmost = [this](Ring& ring) {
      return std::max_element(ring.begin(), ring.end(),
                              [this](int a, int b) { return V(a).x() < V(b).x(); });
    };
    const auto hole = std::max_element(holes_.begin(), holes_.end(), [&](Ring& a, Ring& b) {
      return V(*rightmost(a)).x() < V(*rightmost(b)).x();
    });
    std::rotate(hole->begin(), rightmost(*hole), hole->end());
    const std::size_t anchor = FindVisible(hole->front());
    Ring bridge(hole->begin(), hole->end());
    bridge.push_back(hole->front());
    bridge.push_back(ring_[anchor]);
    ring_.insert(ring_.begin() + static_cast<std::ptrdiff_t>(anchor) + 1, bridge.begin(),
                 bridge.end());
    holes_.erase(hole);
  }

  // The position in the outer ring nearest to a hole's vertex and visible from it.
  std::size_t FindVisible(int from) const {
    std::vector<std::size_t> order(ring_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return (At(a) - V(from)).squaredNorm() < (At(b) - V(from)).squaredNorm();
    });
    for (const std::size_t position : order) {
      if (InCone(position, V(from)) && Sees(V(from), At(position))) return position;
    }
    return order.front();  // unreachable for a simple region
  }

  // Whether the direction from a ring vertex to `p` starts inside of the ring.
  bool InCone(std::size_t position, const Vector2& p) const {
    const Vector2& previous = At(position + ring_.size() - 1);
    const Vector2 &apex = At(position), &next = At(position + 1);
    if (Cross(previous, apex, next) > 0) {
      return Cross(apex, next, p) > 0 && Cross(previous, apex, p) > 0;
    }
    return Cross(apex, next, p) > 0 || Cross(previous, apex, p) > 0;
  }

  bool Sees(const Vector2& a, const Vector2& b) const {
    const auto blocked_by = [&](const Ring& ring) {
      for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
        if (Blocks(a, b, V(ring[j]), V(ring[i]))) return true;
      }
      return false;
    };
    return !blocked_by(ring_) && std::none_of(holes_.begin(), holes_.end(), blocked_by);
  }

  // The next ear at or after `start`. Rounding can hide every ear; then the corner with the widest
  // positive area is cut, which keeps the cover exact up to that rounding.
  std::size_t FindEar(std::size_t start) const {
    const std::size_t n = ring_.size();
    std::size_t widest = start % n;
    double widest_area = -std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t at = (start + k) % n;
      const double area = Cross(At(at + n - 1), At(at), At(at + 1));
      if (area > 0 && IsEmptyEar(at)) return at;
      if (area > widest_area) {
        widest_area = area;
        widest = at;
      }
    }
    return widest;
  }

  bool IsEmptyEar(std::size_t at) const {
    const std::size_t n = ring_.size();
    const Vector2 &a = At(at + n - 1), &b = At(at), &c = At(at + 1);
    for (std::size_t k = 2; k + 1 < n; ++k) {
      const Vector2& p = At(at + k);
      if (p == a || p == b || p == c) continue;  // the other end of a bridge
      if (InClosedTriangle(a, b, c, p)) return false;
    }
    return true;
  }

  std::vector<Vector2> vertices_;
  Ring ring_;
  std::vector<Ring> holes_;
};

// A piece is a counter-clockwise convex ring of vertex indices.
class PieceMerger {
 public:
  PieceMerger(const std::vector<Vector2>& vertices, const std::vector<IndexTriangle>& triangles)
      : vertices_(vertices) {
    for (const IndexTriangle& t : triangles) pieces_.emplace_back(t.begin(), t.end());
  }

  // Hertel and Mehlhorn: drop each diagonal whose removal leaves both of its ends convex.
  std::vector<Polygon> Run() {
    for (std::size_t i = 0; i < pieces_.size(); ++i) IndexEdges(i);
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      while (!pieces_[i].empty() && MergeOneNeighbour(i)) {
      }
    }
    std::vector<Polygon> polygons;
    for (const Ring& piece : pieces_) {
      if (piece.empty()) continue;
      Polygon polygon;
      for (const int index : piece) polygon.push_back(vertices_[static_cast<std::size_t>(index)]);
      polygons.push_back(std::move(polygon));
    }
    return polygons;
  }

 private:
  void IndexEdges(std::size_t piece) {
    const Ring& ring = pieces_[piece];
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      owner_[{ring[j], ring[i]}] = piece;
    }
  }

  bool MergeOneNeighbour(std::size_t piece) {
    const Ring ring = pieces_[piece];
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      const auto other = owner_.find({ring[i], ring[j]});
      if (other == owner_.end() || other->second == piece) continue;
      const std::size_t neighbour = other->second;
      Ring merged = Join(ring, i, pieces_[neighbour], ring[i]);
      if (!IsConvexRing(merged)) continue;
      owner_.erase({ring[i], ring[j]});
      owner_.erase({ring[j], ring[i]});
      pieces_[neighbour].clear();
      pieces_[piece] = std::move(merged);
      IndexEdges(piece);
      return true;
    }
    return false;
  }

  // `a` from position `start` all around to its predecessor, then `b` between those two vertices;
  // `b` runs from vertex `start_vertex` along the shared edge.
  static Ring Join(const Ring& a, std::size_t start, const Ring& b, int start_vertex) {
    Ring merged;
    for (std::size_t k = 0; k < a.size(); ++k) merged.push_back(a[(start + k) % a.size()]);
    const auto at =
        static_cast<std::size_t>(std::find(b.begin(), b.end(), start_vertex) - b.begin());
    for (std::size_t k = 2; k < b.size(); ++k) merged.push_back(b[(at + k) % b.size()]);
    return merged;
  }

  bool IsConvexRing(const Ring& ring) const {
    const std::size_t n = ring.size();
    const auto v = [&](std::size_t i) -> const Vector2& {
      return vertices_[static_cast<std::size_t>(ring[i % n])];
    };
    for (std::size_t i = 0; i < n; ++i) {
      if (Cross(v(i), v(i + 1), v(i + 2)) < 0) return false;
    }
    return true;
  }

  const std::vector<Vector2>& vertices_;
  std::vector<Ring> pieces_;
  std::map<std::pair<int, int>, std::size_t> owner_;
};

}  // namespace

std::vector<IndexTriangle> TriangulateIndices(const Polygon& outline,
                                              const std::vector<Polygon>& holes) {
  if (!IsSimpleRegion(outline, holes)) return {};
  return EarClipper(outline, holes).Run();
}

std::vector<std::array<Vector2, 3>> Triangulate(const Polygon& outline,
                                                const std::vector<Polygon>& holes) {
  if (!IsSimpleRegion(outline, holes)) return {};
  EarClipper clipper(outline, holes);
  std::vector<std::array<Vector2, 3>> corners;
  for (const IndexTriangle& t : clipper.Run()) {
    const std::vector<Vector2>& v = clipper.vertices();
    corners.push_back({v[static_cast<std::size_t>(t[0])], v[static_cast<std::size_t>(t[1])],
                       v[static_cast<std::size_t>(t[2])]});
  }
  return corners;
}

std::vector<Polygon> ConvexPieces(const Polygon& outline, const std::vector<Polygon>& holes) {
  if (!IsSimpleRegion(outline, holes)) return {};
  EarClipper clipper(outline, holes);
  const std::vector<IndexTriangle> triangles = clipper.Run();
  return PieceMerger(clipper.vertices(), triangles).Run();
}

}  // namespace cwm
