// Ear clipping with bridged holes, and convex pieces by merging triangles.
#include <algorithm>
#include <cstdint>
#include <functional>
#include <numeric>
#include <unordered_map>
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
    SortHoles();
    for (std::size_t i = 0; i < holes_.size(); ++i) BridgeHole(i);
    LinkCorners();
    std::vector<IndexTriangle> triangles;
    std::size_t at = 0;
    for (std::size_t left = ring_.size(); left > 3; --left) {
      at = FindEar(at, left);
      triangles.push_back(TriangleAt(at));
      CutOff(at);
      at = corners_[at].next;
    }
    triangles.push_back(TriangleAt(at));
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

  // Rotates each hole so that it starts at its rightmost vertex, and sorts the holes by that
  // vertex, greatest x first. Then only the outer ring lies to the right of the next hole, so some
  // vertex of that ring is visible from it.
  void SortHoles() {
    for (Ring& hole : holes_) {
      const auto rightmost = std::max_element(hole.begin(), hole.end(),
                                              [this](int a, int b) { return V(a).x() < V(b).x(); });
      std::rotate(hole.begin(), rightmost, hole.end());
    }
    std::stable_sort(holes_.begin(), holes_.end(), [this](const Ring& a, const Ring& b) {
      return V(a.front()).x() > V(b.front()).x();
    });
  }

  void BridgeHole(std::size_t index) {
    const Ring& hole = holes_[index];
    const std::size_t anchor = FindVisible(hole.front(), index);
    Ring bridge(hole.begin(), hole.end());
    bridge.push_back(hole.front());
    bridge.push_back(ring_[anchor]);
    ring_.insert(ring_.begin() + static_cast<std::ptrdiff_t>(anchor) + 1, bridge.begin(),
                 bridge.end());
  }

  // The position in the outer ring nearest to a vertex of hole `index` and visible from it.
  std::size_t FindVisible(int from, std::size_t index) const {
    using Candidate = std::pair<double, std::size_t>;  // squared distance, position
    std::vector<Candidate> near(ring_.size());
    for (std::size_t i = 0; i < near.size(); ++i) near[i] = {(At(i) - V(from)).squaredNorm(), i};
    // A heap instead of a sort, because usually one of the first few is visible.
    std::make_heap(near.begin(), near.end(), std::greater<>());
    const std::size_t fallback = near.front().second;  // unreachable for a simple region
    while (!near.empty()) {
      const std::size_t position = near.front().second;
      if (InCone(position, V(from)) && IsVisibleFrom(V(from), At(position), index)) return position;
      std::pop_heap(near.begin(), near.end(), std::greater<>());
      near.pop_back();
    }
    return fallback;
  }

  // True if the direction from a ring vertex to `p` starts inside the ring.
  bool InCone(std::size_t position, const Vector2& p) const {
    const Vector2& previous = At(position + ring_.size() - 1);
    const Vector2 &apex = At(position), &next = At(position + 1);
    if (Cross(previous, apex, next) > 0) {
      return Cross(apex, next, p) > 0 && Cross(previous, apex, p) > 0;
    }
    return Cross(apex, next, p) > 0 || Cross(previous, apex, p) > 0;
  }

  // True if neither the outer ring nor the holes from `first_hole` on, which are not bridged to it
  // yet, block the segment from a to b.
  bool IsVisibleFrom(const Vector2& a, const Vector2& b, std::size_t first_hole) const {
    const auto blocked_by = [&](const Ring& ring) {
      for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
        if (Blocks(a, b, V(ring[j]), V(ring[i]))) return true;
      }
      return false;
    };
    return !blocked_by(ring_) &&
           std::none_of(holes_.begin() + static_cast<std::ptrdiff_t>(first_hole), holes_.end(),
                        blocked_by);
  }

  // A position of the ring while ears are cut off.
  struct Corner {
    std::size_t previous = 0, next = 0;
    double area = 0;        // twice that of the triangle with its neighbours; positive if convex
    bool is_ear = false;    // convex, without another corner in the triangle
    bool is_blunt = false;  // reflex or straight; a corner that becomes convex stays convex
  };

  const Vector2& C(std::size_t at) const { return V(ring_[at]); }
  IndexTriangle TriangleAt(std::size_t at) const {
    return {ring_[corners_[at].previous], ring_[at], ring_[corners_[at].next]};
  }

  void LinkCorners() {
    const std::size_t n = ring_.size();
    corners_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      corners_[i].previous = (i + n - 1) % n;
      corners_[i].next = (i + 1) % n;
    }
    for (std::size_t i = 0; i < n; ++i) {
      Measure(i);
      if (corners_[i].is_blunt) blunt_.push_back(i);
    }
    for (std::size_t i = 0; i < n; ++i) corners_[i].is_ear = IsEar(i);
  }

  void Measure(std::size_t at) {
    Corner& corner = corners_[at];
    corner.area = Cross(C(corner.previous), C(at), C(corner.next));
    corner.is_blunt = !(corner.area > 0);
  }

  void CutOff(std::size_t at) {
    const std::size_t previous = corners_[at].previous, next = corners_[at].next;
    corners_[previous].next = next;
    corners_[next].previous = previous;
    corners_[at].is_blunt = false;
    for (const std::size_t neighbour : {previous, next}) Measure(neighbour);
    std::erase_if(blunt_, [this](std::size_t i) { return !corners_[i].is_blunt; });
    // The other corners stay ears or not, whatever happens to this one.
    for (const std::size_t neighbour : {previous, next}) {
      corners_[neighbour].is_ear = IsEar(neighbour);
    }
  }

  // The next ear at or after `start` among the `count` remaining corners. If rounding hides every
  // ear, the corner with the largest area, which keeps the cover exact up to that rounding.
  std::size_t FindEar(std::size_t start, std::size_t count) const {
    std::size_t widest = start, at = start;
    for (std::size_t k = 0; k < count; ++k, at = corners_[at].next) {
      if (corners_[at].is_ear) return at;
      if (corners_[at].area > corners_[widest].area) widest = at;
    }
    return widest;
  }

  // True if the corner is convex and its triangle contains no other corner. Only blunt corners are
  // tested: a triangle that contains any corner of the ring contains a blunt one.
  bool IsEar(std::size_t at) const {
    if (!(corners_[at].area > 0)) return false;
    const Vector2 &a = C(corners_[at].previous), &b = C(at), &c = C(corners_[at].next);
    return std::none_of(blunt_.begin(), blunt_.end(), [&](std::size_t i) {
      const Vector2& p = C(i);
      if (p == a || p == b || p == c) return false;  // a neighbour, or the other end of a bridge
      return InClosedTriangle(a, b, c, p);
    });
  }

  std::vector<Vector2> vertices_;
  Ring ring_;
  std::vector<Ring> holes_;
  std::vector<Corner> corners_;     // one per position of the ring
  std::vector<std::size_t> blunt_;  // positions of the remaining blunt corners
};

// Merges triangles into convex pieces. A piece is a counter-clockwise convex ring of vertex
// indices.
class PieceMerger {
 public:
  PieceMerger(const std::vector<Vector2>& vertices, const std::vector<IndexTriangle>& triangles)
      : vertices_(vertices) {
    for (const IndexTriangle& t : triangles) pieces_.emplace_back(t.begin(), t.end());
  }

  // Hertel and Mehlhorn: removes each diagonal whose removal leaves both of its ends convex. Pieces
  // and their corner angles only grow, so a diagonal that could not be removed once never can be.
  std::vector<Polygon> Run() {
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      const Ring& ring = pieces_[i];
      for (std::size_t k = 0; k < ring.size(); ++k) owner_[Key(ring[k], ring[Next(ring, k)])] = i;
    }
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      for (std::size_t k = 0; k < pieces_[i].size();) {
        if (!MergeAcross(i, k)) ++k;
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
  static std::uint64_t Key(int from, int to) {
    return static_cast<std::uint64_t>(from) << 32 | static_cast<std::uint32_t>(to);
  }
  static std::size_t Next(const Ring& ring, std::size_t k) {
    return k + 1 < ring.size() ? k + 1 : 0;
  }
  static std::size_t Previous(const Ring& ring, std::size_t k) {
    return k > 0 ? k - 1 : ring.size() - 1;
  }
  bool IsConvexAt(int a, int b, int c) const {
    const auto v = [this](int index) -> const Vector2& {
      return vertices_[static_cast<std::size_t>(index)];
    };
    return Cross(v(a), v(b), v(c)) >= 0;
  }

  // Merges the piece beyond edge k into this piece, which then has that piece's edges from position
  // k on. False if there is no such piece or the union would not be convex.
  bool MergeAcross(std::size_t piece, std::size_t k) {
    Ring& ring = pieces_[piece];
    const int from = ring[k], to = ring[Next(ring, k)];
    const auto other = owner_.find(Key(to, from));
    if (other == owner_.end() || other->second == piece) return false;
    Ring& beyond = pieces_[other->second];
    const auto at =
        static_cast<std::size_t>(std::find(beyond.begin(), beyond.end(), from) - beyond.begin());
    const std::size_t to_at = Previous(beyond, at);
    const int before = ring[Previous(ring, k)], after = ring[Next(ring, Next(ring, k))];
    if (!IsConvexAt(before, from, beyond[Next(beyond, at)])) return false;
    if (!IsConvexAt(beyond[Previous(beyond, to_at)], to, after)) return false;
    owner_.erase(other);
    owner_.erase(Key(from, to));
    Ring chain;  // the vertices of the other piece between `from` and `to`
    for (std::size_t i = Next(beyond, at); i != to_at; i = Next(beyond, i)) {
      chain.push_back(beyond[i]);
    }
    beyond.clear();
    ring.insert(ring.begin() + static_cast<std::ptrdiff_t>(k) + 1, chain.begin(), chain.end());
    for (std::size_t i = 0, e = k; i <= chain.size(); ++i, e = Next(ring, e)) {
      owner_[Key(ring[e], ring[Next(ring, e)])] = piece;
    }
    return true;
  }

  const std::vector<Vector2>& vertices_;
  std::vector<Ring> pieces_;
  std::unordered_map<std::uint64_t, std::size_t> owner_;  // the piece of each directed edge
};

// True if a simple counter-clockwise polygon is convex.
bool IsConvexPolygon(const Polygon& polygon) {
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (Cross(polygon[i], polygon[(i + 1) % n], polygon[(i + 2) % n]) < 0) return false;
  }
  return true;
}

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
  Polygon ring = outline;
  if (SignedArea_m2(ring) < 0) std::reverse(ring.begin(), ring.end());
  if (holes.empty() && IsConvexPolygon(ring)) return {std::move(ring)};
  EarClipper clipper(outline, holes);
  const std::vector<IndexTriangle> triangles = clipper.Run();
  return PieceMerger(clipper.vertices(), triangles).Run();
}

}  // namespace cwm
