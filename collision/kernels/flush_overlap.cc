#include "collision/kernels/flush_overlap.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace cwm::collision {
namespace {

// Shares of the meshes' size: the largest gap of touching triangles (kUnsure in
// triangle_overlap.cc), the distance of test points beside a contact, and the shortest line of
// contact that is used.
constexpr double kTouching = 2e-10, kOffsetAlongFace = 2e-6, kMinLineLength = 1e-5;
// Depth of a test point behind the face, as a share of its distance beside the line: 3 degrees.
constexpr double kOffsetBehindFace = 0.05;
// Position of the test points along a line of contact. Not the middle, where corners of other
// triangles are more likely.
constexpr double kPlaceOnLine = 0.47;
constexpr std::size_t kMaxPairs = 128;  // tested pairs, spread evenly over those that touch
constexpr int kMaxDoublings = 24;       // from kOffsetAlongFace to beyond any mesh

using PolygonCorners = std::vector<Vector3>;

// The part of a polygon behind a plane, that is on the side opposite to the normal.
PolygonCorners ClippedBehind(const PolygonCorners& polygon, const Vector3& on_plane,
                             const Vector3& normal) {
  PolygonCorners kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double of_p = normal.dot(p - on_plane), of_q = normal.dot(q - on_plane);
    if (of_p <= 0) kept.push_back(p);
    if ((of_p < 0 && of_q > 0) || (of_p > 0 && of_q < 0)) {
      kept.push_back(p + of_p / (of_p - of_q) * (q - p));
    }
  }
  return kept;
}

Vector3 CrossOf(const TrianglePoints& t) { return (t[1] - t[0]).cross(t[2] - t[0]); }

// The contact of two triangles: the part of `b` that lies within `near_m` of `a`.
PolygonCorners ContactOf(const TouchingTriangles& pair, double near_m) {
  const Vector3 normal = CrossOf(pair.a).stableNormalized();
  PolygonCorners polygon(pair.b.begin(), pair.b.end());
  for (const double side : {1.0, -1.0}) {
    polygon = ClippedBehind(polygon, pair.a[0] + side * near_m * normal, side * normal);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 outward = (pair.a[(k + 1) % 3] - pair.a[k]).cross(normal).stableNormalized();
    polygon = ClippedBehind(polygon, pair.a[k] + near_m * outward, outward);
  }
  return polygon;
}

class FlushOverlapSearch {
 public:
  FlushOverlapSearch(const ClosedPair& pair, WorkCounter* work)
      : pair_(pair),
        X_BA_(pair.X_AB.inverse(Eigen::Isometry)),
        size_m_(pair.a.nodes().front().radius_m + pair.b.nodes().front().radius_m),
        work_(work) {}

  std::optional<Vector3> Beside(const TouchingTriangles& touching) const {
    const Vector3 normals[] = {CrossOf(touching.a).stableNormalized(),
                               CrossOf(touching.b).stableNormalized()};
    // Coordinates are rounded in proportion to their distance from the frame's origin.
    const double near_m = kTouching * (size_m_ + touching.a[0].cwiseAbs().maxCoeff());
    const PolygonCorners contact = ContactOf(touching, near_m);
    for (std::size_t i = 0; i < contact.size(); ++i) {
      const Vector3 line = contact[(i + 1) % contact.size()] - contact[i];
      if (line.norm() < kMinLineLength * size_m_) continue;
      const Vector3 at = contact[i] + kPlaceOnLine * line;
      for (const Vector3& normal : normals) {
        const Vector3 along_face = normal.cross(line).stableNormalized();
        for (const double side : {1.0, -1.0}) {
          const Vector3 p =
              at + kOffsetAlongFace * size_m_ * (side * along_face - kOffsetBehindFace * normal);
          if (IsInBoth(p)) return MovedInward(p, -normal);
          if (MustEnd(work_, 0)) return std::nullopt;
        }
      }
    }
    return std::nullopt;
  }

 private:
  bool IsInBoth(const Vector3& p) const {
    return !MustEnd(work_, 2 * kStepsPerContainmentTest) && pair_.a.Contains(p, work_) &&
           pair_.b.Contains(X_BA_ * p, work_);
  }

  Vector3 MovedInward(const Vector3& from, const Vector3& inward) const {
    Vector3 deepest = from;
    double step_m = kOffsetAlongFace * size_m_;
    for (int k = 0; k < kMaxDoublings; ++k, step_m *= 2) {
      const Vector3 next = from + step_m * inward;
      if (!IsInBoth(next)) break;
      deepest = next;
    }
    return deepest;
  }

  const ClosedPair& pair_;
  const Pose X_BA_;
  const double size_m_;
  WorkCounter* const work_;
};

}  // namespace

std::optional<Vector3> FindPointInBoth(const ClosedPair& pair,
                                       std::span<const TouchingTriangles> touching,
                                       WorkCounter* work) {
  const FlushOverlapSearch search(pair, work);
  const std::size_t stride = (touching.size() + kMaxPairs - 1) / kMaxPairs;
  for (std::size_t i = 0; i < touching.size(); i += stride) {
    if (const auto found = search.Beside(touching[i])) return found;
  }
  return std::nullopt;
}

}  // namespace cwm::collision
