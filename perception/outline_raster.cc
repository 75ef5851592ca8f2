#include "perception/outline_raster.h"

#include <algorithm>
#include <limits>

namespace cwm::perception {
namespace {

// chosen: cells along each side; edges cross a few percent of them.
constexpr int kSide = 64;
// derived: a tolerance in cells; rounding of doubles moves points and edges by less.
constexpr double kSlack = std::numeric_limits<float>::epsilon();

int CellOf(double in_cells) { return std::clamp(static_cast<int>(in_cells), 0, kSide - 1); }

}  // namespace

OutlineRaster::OutlineRaster(const Polygon& outline)
    : outline_(outline), cells_(std::size_t{kSide} * kSide, Place::kOutside) {
  for (const Vector2& p : outline) bounds_.extend(p);
  if (bounds_.isEmpty() || !(bounds_.sizes().minCoeff() > 0)) {
    std::fill(cells_.begin(), cells_.end(), Place::kAtBorder);
    return;
  }
  cells_per_m_ = Vector2::Constant(kSide).cwiseQuotient(bounds_.sizes());
  for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
    MarkEdge(InCells(outline[j]), InCells(outline[i]));
  }
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      Place& place = At(column, row);
      if (place == Place::kAtBorder) continue;
      const Vector2 middle =
          bounds_.min() + Vector2(column + 0.5, row + 0.5).cwiseQuotient(cells_per_m_);
      if (cwm::Contains(outline, middle)) place = Place::kInside;
    }
  }
}

OutlineRaster::Place& OutlineRaster::At(int column, int row) {
  return cells_[static_cast<std::size_t>(row) * kSide + static_cast<std::size_t>(column)];
}

// Marks, row by row, the cells between the places where the edge enters and leaves the row.
void OutlineRaster::MarkEdge(const Vector2& a, const Vector2& b) {
  const Vector2& low = a.y() <= b.y() ? a : b;
  const Vector2& high = a.y() <= b.y() ? b : a;
  const double height = high.y() - low.y();
  const auto x_at = [&](double y) {
    const double t = height > 0 ? std::clamp((y - low.y()) / height, 0.0, 1.0) : 0;
    return low.x() + t * (high.x() - low.x());
  };
  for (int row = CellOf(low.y() - kSlack); row <= CellOf(high.y() + kSlack); ++row) {
    double from = x_at(row - kSlack), to = x_at(row + 1 + kSlack);
    if (!(height > 0)) to = high.x();
    if (from > to) std::swap(from, to);
    for (int column = CellOf(from - kSlack); column <= CellOf(to + kSlack); ++column) {
      At(column, row) = Place::kAtBorder;
    }
  }
}

bool OutlineRaster::Contains(const Vector2& point) const {
  if (!bounds_.contains(point)) return false;
  const Vector2 at = InCells(point);
  const auto cell =
      static_cast<std::size_t>(CellOf(at.y())) * kSide + static_cast<std::size_t>(CellOf(at.x()));
  if (cells_[cell] == Place::kAtBorder) return cwm::Contains(outline_, point);
  return cells_[cell] == Place::kInside;
}

}  // namespace cwm::perception
