// Quickhull (Barber, Dobkin and Huhdanpaa 1996) in three dimensions.
#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <unordered_map>

#include "collision/geometry/triangle_mesh.h"

namespace cwm {
namespace {

struct Face {
  std::array<int, 3> vertices;
  std::array<int, 3> neighbours;  // across the edge vertices[i] -> vertices[i + 1]
  Vector3 normal;
  std::vector<int> outside;  // points beyond this face that no earlier face took
  bool alive = true;
};

struct HorizonEdge {
  int from, to, beyond;  // `beyond` is the face that stays
};

// Points whose distance to a face is below `tolerance` count as lying on it.
class Quickhull {
 public:
  Quickhull(const std::vector<Vector3>& points, double tolerance)
      : points_(points), tolerance_(tolerance) {}

  // Nothing when the points span no volume or rounding broke the topology.
  std::optional<TriangleMesh> Run() {
    if (!BuildSimplex()) return std::nullopt;
    do {
      while (!pending_.empty()) {
        const int face = pending_.back();
        pending_.pop_back();
        if (!F(face).alive || F(face).outside.empty()) continue;
        if (!AddPoint(face)) return std::nullopt;
      }
      ReviewUnclaimed();
    } while (!pending_.empty());
    if (!IsLocallyConvex()) return std::nullopt;
    TriangleMesh mesh = Extract();
    if (!SharesEdges(mesh)) return std::nullopt;
    return mesh;
  }

 private:
  const Vector3& P(int index) const { return points_[static_cast<std::size_t>(index)]; }
  Face& F(int index) { return faces_[static_cast<std::size_t>(index)]; }
  const Face& F(int index) const { return faces_[static_cast<std::size_t>(index)]; }
  double Height(const Face& face, const Vector3& p) const {
    return face.normal.dot(p - P(face.vertices[0]));
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
    Face face{.vertices = v, .neighbours = neighbours, .normal = {}, .outside = {}};
    face.normal = (P(v[1]) - P(v[0])).cross(P(v[2]) - P(v[0])).stableNormalized();
    return face;
  }

  // Gives each point to one of the faces from `first_new` on that it lies beyond. Points beyond none
  // wait for ReviewUnclaimed: they are inside, but among coplanar faces a point may also lose a face
  // that it saw and see only old ones.
  void Distribute(const std::vector<int>& candidates, std::size_t first_new) {
    for (const int index : candidates) {
      if (!Claim(index, first_new)) unclaimed_.push_back(index);
    }
  }

  bool Claim(int index, std::size_t first_face) {
    for (std::size_t f = first_face; f < faces_.size(); ++f) {
      if (!faces_[f].alive || Height(faces_[f], P(index)) <= tolerance_) continue;
      if (faces_[f].outside.empty()) pending_.push_back(static_cast<int>(f));
      faces_[f].outside.push_back(index);
      return true;
    }
    return false;
  }

  // The hull only grows: what lies beyond none of its faces now is inside for good. Once for all
  // points, because a search through all faces after each step takes the cube of their count.
  void ReviewUnclaimed() {
    std::erase_if(faces_live_, [this](int f) { return !F(f).alive; });
    for (std::size_t f = live_until_; f < faces_.size(); ++f) {
      if (faces_[f].alive) faces_live_.push_back(static_cast<int>(f));
    }
    live_until_ = faces_.size();
    for (const int index : unclaimed_) {
      const auto seen = std::find_if(faces_live_.begin(), faces_live_.end(),
                                     [&](int f) { return Height(F(f), P(index)) > tolerance_; });
      if (seen == faces_live_.end()) continue;
      if (F(*seen).outside.empty()) pending_.push_back(*seen);
      F(*seen).outside.push_back(index);
    }
    unclaimed_.clear();
  }

  bool AddPoint(int seed) {
    const Face& face = F(seed);
    const int apex = *std::max_element(face.outside.begin(), face.outside.end(), [&](int a, int b) {
      return Height(face, P(a)) < Height(face, P(b));
    });
    std::vector<HorizonEdge> horizon;
    std::vector<int> orphans;
    RemoveVisible(seed, P(apex), horizon, orphans);
    return Cap(apex, horizon) && (Distribute(orphans, faces_.size() - horizon.size()), true);
  }

  void RemoveVisible(int seed, const Vector3& eye, std::vector<HorizonEdge>& horizon,
                     std::vector<int>& orphans) {
    std::vector<int> stack = {seed}, removed;
    F(seed).alive = false;
    while (!stack.empty()) {
      const int at = stack.back();
      stack.pop_back();
      removed.push_back(at);
      for (const int next : F(at).neighbours) {
        // A face in one plane with the eye goes too: kept, its edges could line up with the eye
        // and raise faces without area.
        if (!F(next).alive || Height(F(next), eye) < -tolerance_) continue;
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

  // A fan from the horizon to the apex; false when the horizon is not one simple loop.
  bool Cap(int apex, const std::vector<HorizonEdge>& horizon) {
    const int base = static_cast<int>(faces_.size());
    std::unordered_map<int, int> starting_at, ending_at;
    for (std::size_t i = 0; i < horizon.size(); ++i) {
      const int index = base + static_cast<int>(i);
      if (!starting_at.emplace(horizon[i].from, index).second) return false;
      if (!ending_at.emplace(horizon[i].to, index).second) return false;
    }
    for (std::size_t i = 0; i < horizon.size(); ++i) {
      const HorizonEdge& edge = horizon[i];
      const auto next = starting_at.find(edge.to), previous = ending_at.find(edge.from);
      if (next == starting_at.end() || previous == ending_at.end()) return false;
      faces_.push_back(
          MakeFace({edge.from, edge.to, apex}, {edge.beyond, next->second, previous->second}));
      Face& beyond = F(edge.beyond);
      for (std::size_t k = 0; k < 3; ++k) {
        if (beyond.vertices[k] == edge.to) beyond.neighbours[k] = base + static_cast<int>(i);
      }
    }
    return true;
  }

  // Rounding on slivers can leave dents; ten tolerances are what coplanar neighbours may differ by.
  bool IsLocallyConvex() const {
    for (const Face& face : faces_) {
      if (!face.alive) continue;
      for (const int next : face.neighbours) {
        for (const int v : F(next).vertices) {
          if (Height(face, P(v)) > 10 * tolerance_) return false;
        }
      }
    }
    return true;
  }

  TriangleMesh Extract() const {
    TriangleMesh mesh;
    std::unordered_map<int, std::uint32_t> renumbered;
    for (const Face& face : faces_) {
      if (!face.alive) continue;
      TriangleMesh::Triangle triangle;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto [at, is_new] =
            renumbered.emplace(face.vertices[i], static_cast<std::uint32_t>(mesh.vertices.size()));
        if (is_new) mesh.vertices.push_back(P(face.vertices[i]));
        triangle[i] = at->second;
      }
      mesh.triangles.push_back(triangle);
    }
    return mesh;
  }

  const std::vector<Vector3>& points_;
  const double tolerance_;
  std::vector<Face> faces_;
  std::vector<int> pending_;    // faces with points outside, some of them gone meanwhile
  std::vector<int> unclaimed_;  // points beyond no face of the last step
  std::vector<int> faces_live_;
  std::size_t live_until_ = 0;  // faces below are in faces_live_ if they lived at the last review
};

}  // namespace

TriangleMesh ConvexHull3(const std::vector<Vector3>& points, double coarsest_share) {
  if (points.size() < 4) return {};
  Eigen::AlignedBox3d bounds;
  for (const Vector3& p : points) bounds.extend(p);
  const double extent = bounds.diagonal().norm();
  // Nearly coplanar points can break the topology at the tightest tolerance; a coarser one then
  // merges them.
  for (double relative = 1e-12; relative < 2 * coarsest_share; relative *= 10) {
    if (auto hull = Quickhull(points, relative * extent).Run()) return *std::move(hull);
  }
  return {};
}

}  // namespace cwm
