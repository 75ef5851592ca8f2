// Tests for very many points if they lie in a polygon.
#pragma once

#include <vector>

#include "collision/geometry/polygon.h"

namespace cwm::perception {

// Gives the same result as Contains(outline, point): cells that no edge crosses are completely
// inside or outside, and only points in the others are tested with the polygon, which must outlive
// this.
class OutlineRaster {
 public:
  explicit OutlineRaster(const Polygon& outline);

  bool Contains(const Vector2& point) const;

 private:
  enum class Place : char { kOutside, kInside, kAtBorder };

  void MarkEdge(const Vector2& a, const Vector2& b);
  Vector2 InCells(const Vector2& point) const {
    return (point - bounds_.min()).cwiseProduct(cells_per_m_);
  }
  Place& At(int column, int row);

  const Polygon& outline_;
  Eigen::AlignedBox2d bounds_;
  Vector2 cells_per_m_ = Vector2::Zero();
  std::vector<Place> cells_;
};

}  // namespace cwm::perception
