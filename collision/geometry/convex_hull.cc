// Quickhull (Barber, Dobkin and Huhdanpaa 1996) in three dimensions, with exact decisions.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

#include "collision/geometry/triangle_mesh.h"

namespace cwm {
namespace {

// Share of the extent. A point that is nowhere farther outside the faces than this is not a corner.
constexpr double kNoCorner = 1e-12;
// Share of the extent beyond which the sign of a height in double precision is certain.
// derived: 8 roundings, doubled.
constexpr double kMinReliableHeight = 4e-15;

// A point on a lattice of 2^-60 of the extent. Determinants are exact there, so visibility of a
// face never depends on rounding, which could contradict itself and break the surface. Slivers are
// common: the corners of a rotated box in single precision, with points along its edges.
struct Cell {
  std::int64_t x = 0, y = 0, z = 0;  // below 2^60

  Cell operator-(const Cell& other) const { return {x - other.x, y - other.y, z - other.z}; }
};

// GCC's 128-bit integer; `__extension__` suppresses the warning about it.
__extension__ using Wide = __int128;

struct WideVector {
  Wide x, y, z;  // below 2^123
};

Wide Minor(std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d) {
  return Wide{a} * d - Wide{b} * c;
}

WideVector Cross(const Cell& u, const Cell& v) {
  return {Minor(u.y, u.z, v.y, v.z), Minor(u.z, u.x, v.z, v.x), Minor(u.x, u.y, v.x, v.y)};
}

// The sign of the scalar product of n and v, which is below 2^186; n is split into 64-bit halves.
int SignOfProduct(const WideVector& n, const Cell& v) {
  const auto low = [](Wide value, std::int64_t by) {
    return static_cast<Wide>(static_cast<std::uint64_t>(value)) * by;
  };
  const Wide lows = low(n.x, v.x) + low(n.y, v.y) + low(n.z, v.z);
  const Wide highs = (n.x >> 64) * v.x + (n.y >> 64) * v.y + (n.z >> 64) * v.z + (lows >> 64);
  if (highs != 0) return highs > 0 ? 1 : -1;
  return static_cast<std::uint64_t>(lows) != 0 ? 1 : 0;
}

struct Face {
  std::array<int, 3> vertices;
  std::array<int, 3> neighbours;  // across the edge vertices[i] -> vertices[i + 1]
  Vector3 normal;
  std::vector<int> outside;  // points outside this face that no earlier face claimed
  bool alive = true;
};

struct HorizonEdge {
  int from, to, beyond;  // `beyond` is the face that stays
};

class Quickhull {
 public:
  Quickhull(const std::vector<Vector3>& points, const Eigen::AlignedBox3d& bounds,
            WorkCounter* work)
      : points_(points),
        extent_(bounds.diagonal().norm()),
        tolerance_(kNoCorner * extent_),
        work_(work) {
    const int exponent = 59 - std::ilogb(extent_);
    const auto cell = [&](double p, double origin) {
      return static_cast<std::int64_t>(
          std::llround(std::ldexp(static_cast<long double>(p) - origin, exponent)));
    };
    cells_.reserve(points.size());
    faces_.reserve(kFacesOfPoint * points.size());  // memory that is not touched costs nothing
    for (const Vector3& p : points) {
      cells_.push_back({cell(p.x(), bounds.min().x()), cell(p.y(), bounds.min().y()),
                        cell(p.z(), bounds.min().z())});
    }
  }

  // The hull; empty if the points span no volume or `work` ended it. Terminates, because each step
  // adds a point that lies strictly outside, and no face has that point outside afterwards.
  TriangleMesh Run() {
    if (!BuildSimplex()) return {};
    do {
      while (!pending_.empty()) {
        if (HasEnded(work_)) return {};
        const int face = pending_.back();
        pending_.pop_back();
        if (F(face).alive && !F(face).outside.empty()) AddPoint(face);
      }
      ReassignPoints();
    } while (!pending_.empty() && !HasEnded(work_));
    if (HasEnded(work_)) return {};
    return Extract();
  }

 private:
  const Vector3& P(int index) const { return points_[static_cast<std::size_t>(index)]; }
  Face& F(int index) { return faces_[static_cast<std::size_t>(index)]; }
  const Face& F(int index) const { return faces_[static_cast<std::size_t>(index)]; }
  const Cell& CellOf(int index) const { return cells_[static_cast<std::size_t>(index)]; }
  double Height(const Face& face, int point) const {
    return face.normal.dot(P(point) - P(face.vertices[0]));
  }
  // True if the point sees the face from outside; a point in the plane of the face counts.
  bool IsSeen(const Face& face, int from) const {
    const double height = Height(face, from);
    if (std::abs(height) > kMinReliableHeight * extent_) return height > 0;
    return SignOfProduct(CrossOf(face.vertices), CellOf(from) - CellOf(face.vertices[0])) >= 0;
  }
  WideVector CrossOf(const std::array<int, 3>& v) const {
    return Cross(CellOf(v[1]) - CellOf(v[0]), CellOf(v[2]) - CellOf(v[0]));
  }

  template <class Measure>
  int Farthest(Measure&& measure) const {
    int best = 0;
    double best_value = -1;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double value = measure(points_[i]);
      if (value > best_value) {
        best_value = value;
        best = static_cast<int>(i);
      }
    }
    return best;
  }

  bool BuildSimplex() {
    const int a = Farthest([&](const Vector3& p) { return (p - points_[0]).norm(); });
    const int b = Farthest([&](const Vector3& p) { return (p - P(a)).norm(); });
    const Vector3 line = P(b) - P(a);
    if (!(line.norm() > tolerance_)) return false;
    const Vector3 u = line.normalized();
    const auto off_line = [&](const Vector3& p) -> Vector3 {
      return (p - P(a)) - u.dot(p - P(a)) * u;
    };
    int c = Farthest([&](const Vector3& p) { return off_line(p).norm(); });
    if (!(off_line(P(c)).norm() > tolerance_)) return false;
    const Vector3 n = u.cross(off_line(P(c))).normalized();
    int d = Farthest([&](const Vector3& p) { return std::abs(n.dot(p - P(a))); });
    const double height = n.dot(P(d) - P(a));
    if (!(std::abs(height) > tolerance_)) return false;
    if (height > 0) std::swap(c, d);  // d below (a, b, c)
    faces_.push_back(MakeFace({a, b, c}, {1, 2, 3}));
    faces_.push_back(MakeFace({b, a, d}, {0, 3, 2}));
    faces_.push_back(MakeFace({c, b, d}, {0, 1, 3}));
    faces_.push_back(MakeFace({a, c, d}, {0, 2, 1}));
    std::vector<int> all(points_.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
    Distribute(all, 0);
    return true;
  }

  Face MakeFace(const std::array<int, 3>& v, const std::array<int, 3>& neighbours) const {
    const WideVector n = CrossOf(v);
    Face face{.vertices = v, .neighbours = neighbours, .normal = {}, .outside = {}};
    face.normal =
        Vector3(static_cast<double>(n.x), static_cast<double>(n.y), static_cast<double>(n.z))
            .stableNormalized();
    return face;
  }

  // Assigns each point to one of the faces from `first_new` on that it lies outside of. Points
  // outside none of them wait for ReassignPoints: they are inside the hull or outside an older
  // face.
  void Distribute(const std::vector<int>& candidates, std::size_t first_new) {
    for (const int index : candidates) {
      if (CountHeights(faces_.size() - first_new)) return;
      if (!AssignToFace(index, first_new)) unassigned_.push_back(index);
    }
  }

  // Counts the work of that many heights; true if `work` ends the computation.
  bool CountHeights(std::size_t count) { return MustEnd(work_, 1 + count / kHeightsPerStep); }

  bool AssignToFace(int index, std::size_t first_face) {
    for (std::size_t f = first_face; f < faces_.size(); ++f) {
      if (!faces_[f].alive || Height(faces_[f], index) <= tolerance_) continue;
      if (faces_[f].outside.empty()) pending_.push_back(static_cast<int>(f));
      faces_[f].outside.push_back(index);
      return true;
    }
    return false;
  }

  // The first face that the point lies outside of, found in pieces that `work` can end.
  std::vector<int>::iterator FirstSeenBy(int index) {
    auto first = faces_live_.begin();
    while (first != faces_live_.end()) {
      const std::ptrdiff_t count =
          std::min<std::ptrdiff_t>(kFacesPerReview, faces_live_.end() - first);
      if (CountHeights(static_cast<std::size_t>(count))) break;
      const auto seen = std::find_if(first, first + count,
                                     [&](int f) { return Height(F(f), index) > tolerance_; });
      if (seen != first + count) return seen;
      first += count;
    }
    return faces_live_.end();
  }

  // Assigns the unclaimed points to the faces that they lie outside of and drops the others: the
  // hull only grows, so they stay inside. One review for all points, because a search through all
  // faces after each step would take cubic time.
  void ReassignPoints() {
    std::erase_if(faces_live_, [this](int f) { return !F(f).alive; });
    for (std::size_t f = live_until_; f < faces_.size(); ++f) {
      const bool begins_block = (f - live_until_) % kFacesPerReview == 0;
      if (begins_block && CountHeights(std::min(kFacesPerReview, faces_.size() - f))) return;
      if (faces_[f].alive) faces_live_.push_back(static_cast<int>(f));
    }
    live_until_ = faces_.size();
    for (const int index : unassigned_) {
      const auto seen = FirstSeenBy(index);
      if (HasEnded(work_)) return;
      if (seen == faces_live_.end()) continue;
      if (F(*seen).outside.empty()) pending_.push_back(*seen);
      F(*seen).outside.push_back(index);
    }
    unassigned_.clear();
  }

  void AddPoint(int seed) {
    const Face& face = F(seed);
    const int apex = *std::max_element(face.outside.begin(), face.outside.end(), [&](int a, int b) {
      return Height(face, a) < Height(face, b);
    });
    std::vector<HorizonEdge> horizon;
    std::vector<int> orphans;
    RemoveVisible(seed, apex, horizon, orphans);
    std::erase(orphans, apex);
    Cap(apex, horizon);
    if (HasEnded(work_)) return;
    Distribute(orphans, faces_.size() - horizon.size());
  }

  void RemoveVisible(int seed, int eye, std::vector<HorizonEdge>& horizon,
                     std::vector<int>& orphans) {
    std::vector<int> stack = {seed}, removed;
    F(seed).alive = false;
    while (!stack.empty()) {
      const int at = stack.back();
      stack.pop_back();
      removed.push_back(at);
      for (const int next : F(at).neighbours) {
        // A face that is coplanar with the eye is removed too: otherwise its edges could be
        // collinear with the eye and lead to faces without area.
        if (!F(next).alive || !IsSeen(F(next), eye)) continue;
        F(next).alive = false;
        stack.push_back(next);
      }
    }
    for (const int at : removed) {
      for (std::size_t i = 0; i < 3; ++i) {
        const int beyond = F(at).neighbours[i];
        if (!F(beyond).alive) continue;
        horizon.push_back({F(at).vertices[i], F(at).vertices[(i + 1) % 3], beyond});
      }
      orphans.insert(orphans.end(), F(at).outside.begin(), F(at).outside.end());
      std::vector<int>().swap(F(at).outside);
    }
  }

  // Adds a fan of faces from the horizon, which is one simple loop, to the apex. The faces are void
  // if `work` ended it.
  void Cap(int apex, const std::vector<HorizonEdge>& horizon) {
    const int base = static_cast<int>(faces_.size());
    std::unordered_map<int, int> starting_at, ending_at;
    for (std::size_t i = 0; i < horizon.size(); ++i) {
      const int index = base + static_cast<int>(i);
      starting_at.emplace(horizon[i].from, index);
      ending_at.emplace(horizon[i].to, index);
    }
    for (std::size_t i = 0; i < horizon.size(); ++i) {
      const std::size_t left = horizon.size() - i;
      const bool begins_block = i % kFacesPerCount == 0;
      if (begins_block && CountHeights(kHeightsOfFace * std::min(left, kFacesPerCount))) return;
      const HorizonEdge& edge = horizon[i];
      faces_.push_back(MakeFace({edge.from, edge.to, apex},
                                {edge.beyond, starting_at.at(edge.to), ending_at.at(edge.from)}));
      Face& beyond = F(edge.beyond);
      for (std::size_t k = 0; k < 3; ++k) {
        if (beyond.vertices[k] == edge.to) beyond.neighbours[k] = base + static_cast<int>(i);
      }
    }
  }

  TriangleMesh Extract() const {
    TriangleMesh mesh;
    constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> renumbered(points_.size(), kNone);
    for (const Face& face : faces_) {
      if (!face.alive) continue;
      TriangleMesh::Triangle triangle;
      for (std::size_t i = 0; i < 3; ++i) {
        std::uint32_t& number = renumbered[static_cast<std::size_t>(face.vertices[i])];
        if (number == kNone) {
          number = static_cast<std::uint32_t>(mesh.vertices.size());
          mesh.vertices.push_back(P(face.vertices[i]));
        }
        triangle[i] = number;
      }
      mesh.triangles.push_back(triangle);
    }
    return mesh;
  }

  static constexpr std::size_t kFacesOfPoint = 8;  // faces made per point if all points are corners
  static constexpr std::size_t kHeightsPerStep = 8;
  // Work is counted in pieces of so many faces, made or reviewed.
  static constexpr std::size_t kFacesPerCount = 256, kFacesPerReview = 8192;
  static constexpr std::size_t kHeightsOfFace = 64;  // cost of making one face, in heights

  const std::vector<Vector3>& points_;
  const double extent_, tolerance_;
  WorkCounter* const work_;
  std::vector<Cell> cells_;
  std::vector<Face> faces_;
  std::vector<int> pending_;     // faces with points outside; some may have been removed since
  std::vector<int> unassigned_;  // points that no new face claimed since the last review
  std::vector<int> faces_live_;
  std::size_t live_until_ = 0;  // lower faces are in faces_live_ if alive at the last review
};

}  // namespace

TriangleMesh ConvexHull3(const std::vector<Vector3>& points, WorkCounter* work) {
  if (points.size() < 4) return {};
  Eigen::AlignedBox3d bounds;
  for (const Vector3& p : points) bounds.extend(p);
  if (!(bounds.diagonal().norm() > 0)) return {};
  return Quickhull(points, bounds, work).Run();
}

}  // namespace cwm
