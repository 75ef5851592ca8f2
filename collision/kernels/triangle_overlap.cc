#include "collision/kernels/triangle_overlap.h"

#include <algorithm>
#include <cmath>

namespace cwm::collision {
namespace {

// chosen: share of the size of both within which a pair counts as nearly touching. Far above the
// rounding of coordinates, below any gap that matters in practice.
constexpr double kUndecidedOverlap = 1e-10;
// A cross product shorter than this share of its factors' lengths has no direction.
constexpr double kDegenerateNormal = 1e-12;

struct Interval {
  double low = 0, high = 0;
};

Interval Along(const TrianglePoints& triangle, const Vector3& axis) {
  const double a = axis.dot(triangle[0]), b = axis.dot(triangle[1]), c = axis.dot(triangle[2]);
  return {std::min({a, b, c}), std::max({a, b, c})};
}

// Combines the verdicts of the axes: one that separates decides.
class Axes {
 public:
  explicit Axes(double size) : size_(size) {}

  // False once an axis separates the two. `made_of` is the product of the lengths of the vectors
  // whose cross product is the axis.
  bool Try(const Vector3& axis, double made_of, const Interval& a, const Interval& b) {
    const double squared = axis.squaredNorm();
    if (squared <= kDegenerateNormal * kDegenerateNormal * made_of * made_of) return true;
    const double unsure = kUndecidedOverlap * size_ * std::sqrt(squared);
    const double gap = std::max(a.low - b.high, b.low - a.high);
    if (gap > unsure) {
      verdict_ = Overlap::kNo;
      return false;
    }
    if (gap > -unsure) verdict_ = Overlap::kUnsure;
    return true;
  }
  Overlap verdict() const { return verdict_; }

 private:
  const double size_;
  Overlap verdict_ = Overlap::kYes;
};

double SizeOf(const TrianglePoints& triangle) {
  return std::max({triangle[0].cwiseAbs().maxCoeff(), triangle[1].cwiseAbs().maxCoeff(),
                   triangle[2].cwiseAbs().maxCoeff()});
}

TrianglePoints EdgesOf(const TrianglePoints& t) { return {t[1] - t[0], t[2] - t[1], t[0] - t[2]}; }

}  // namespace

Overlap TrianglesOverlap(const TrianglePoints& a, const TrianglePoints& b) {
  Axes axes(std::max(SizeOf(a), SizeOf(b)));
  const auto parted = [&](const Vector3& axis, double made_of) {
    return !axes.Try(axis, made_of, Along(a, axis), Along(b, axis));
  };
  const TrianglePoints edges_a = EdgesOf(a), edges_b = EdgesOf(b);
  const Vector3 normal_a = edges_a[0].cross(edges_a[1]), normal_b = edges_b[0].cross(edges_b[1]);
  std::array<double, 3> lengths_a, lengths_b;
  for (std::size_t k = 0; k < 3; ++k) {
    lengths_a[k] = edges_a[k].norm(), lengths_b[k] = edges_b[k].norm();
  }
  if (parted(normal_a, lengths_a[0] * lengths_a[1])) return Overlap::kNo;
  if (parted(normal_b, lengths_b[0] * lengths_b[1])) return Overlap::kNo;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (parted(edges_a[i].cross(edges_b[j]), lengths_a[i] * lengths_b[j])) return Overlap::kNo;
    }
  }
  // In (nearly) coplanar triangles the cross products of edges are all parallel to the normal, so
  // axes in the plane are tested too.
  for (std::size_t k = 0; k < 3; ++k) {
    if (parted(normal_a.cross(edges_a[k]), normal_a.norm() * lengths_a[k])) return Overlap::kNo;
    if (parted(normal_b.cross(edges_b[k]), normal_b.norm() * lengths_b[k])) return Overlap::kNo;
  }
  return axes.verdict();
}

Overlap TriangleOverlapsBox(const TrianglePoints& triangle, const Box& box) {
  const Vector3 half = 0.5 * box.size_m;
  Axes axes(std::max(SizeOf(triangle), half.maxCoeff()));
  const auto parted = [&](const Vector3& axis, double made_of) {
    const double reach = axis.cwiseAbs().dot(half);
    return !axes.Try(axis, made_of, Along(triangle, axis), {-reach, reach});
  };
  for (int k = 0; k < 3; ++k) {
    if (parted(Vector3::Unit(k), 1)) return Overlap::kNo;
  }
  const TrianglePoints edges = EdgesOf(triangle);
  if (parted(edges[0].cross(edges[1]), edges[0].norm() * edges[1].norm())) return Overlap::kNo;
  for (const Vector3& edge : edges) {
    const double length = edge.norm();
    for (int k = 0; k < 3; ++k) {
      if (parted(edge.cross(Vector3::Unit(k)), length)) return Overlap::kNo;
    }
  }
  return axes.verdict();
}

}  // namespace cwm::collision
