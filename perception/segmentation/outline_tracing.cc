#include "perception/segmentation/outline_tracing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "collision/geometry/segment.h"

namespace cwm::perception {
namespace {

// chosen: factors of the tolerance, tried in this order: smaller where simplified borders cross,
// larger where too many corners remain.
constexpr double kToleranceSteps[] = {1, 0.5, 0.25, 1.5, 2.25, 3.4, 5};

// The sides of a block of four cells. Corners, counter-clockwise from the lower left, are the bits
// 1, 2, 4 and 8 of the cases below.
enum Side : std::int8_t { kBottom, kRight, kTop, kLeft, kNoSide };

struct Passage {
  Side from = kNoSide, to = kNoSide;
};

// The borders that pass through a block, with the set on their left.
constexpr std::array<std::array<Passage, 2>, 16> kPassages = {{
    {},                                    // none
    {{{kBottom, kLeft}, {}}},              // lower left
    {{{kRight, kBottom}, {}}},             // lower right
    {{{kRight, kLeft}, {}}},               // lower row
    {{{kTop, kRight}, {}}},                // upper right
    {{{kBottom, kLeft}, {kTop, kRight}}},  // a diagonal, separated
    {{{kTop, kBottom}, {}}},               // right column
    {{{kTop, kLeft}, {}}},                 // all but the upper left
    {{{kLeft, kTop}, {}}},                 // upper left
    {{{kBottom, kTop}, {}}},               // left column
    {{{kRight, kBottom}, {kLeft, kTop}}},  // the other diagonal, separated
    {{{kRight, kTop}, {}}},                // all but the upper right
    {{{kLeft, kRight}, {}}},               // upper row
    {{{kBottom, kRight}, {}}},             // all but the lower right
    {{{kLeft, kBottom}, {}}},              // all but the lower left
    {},                                    // all
}};

class Tracer {
 public:
  explicit Tracer(const CellMask& mask)
      : mask_(mask), width_(mask.width + 2), height_(mask.height + 2) {
    next_.assign(2 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_),
                 kNoIndex);
    for (int y = 0; y + 1 < height_; ++y) {
      for (int x = 0; x + 1 < width_; ++x) LinkBlock(x, y);
    }
  }

  std::vector<Polygon> Loops() {
    std::vector<Polygon> loops;
    for (std::size_t start = 0; start < next_.size(); ++start) {
      if (next_[start] == kNoIndex) continue;
      Polygon loop;
      for (std::size_t at = start; next_[at] != kNoIndex;) {
        Append(loop, PlaceOf(at));
        at = static_cast<std::size_t>(std::exchange(next_[at], kNoIndex));
      }
      loops.push_back(std::move(loop));
    }
    return loops;
  }

 private:
  // Cells count from 1 here, so that a ring of cells outside the mask surrounds it.
  bool Has(int x, int y) const { return mask_.Has(x - 1, y - 1); }

  // The place midway between two neighbouring cells: to the right of (x, y), or above it.
  std::int32_t Midway(int x, int y, bool above) const {
    return 2 * (y * width_ + x) + (above ? 1 : 0);
  }
  Vector2 PlaceOf(std::size_t midway) const {
    const auto cell = static_cast<int>(midway / 2);
    const int column = cell % width_, row = cell / width_;
    const double x = column - 1, y = row - 1;
    return midway % 2 != 0 ? Vector2(x, y + 0.5) : Vector2(x + 0.5, y);
  }

  void LinkBlock(int x, int y) {
    const int corners = (Has(x, y) ? 1 : 0) | (Has(x + 1, y) ? 2 : 0) |
                        (Has(x + 1, y + 1) ? 4 : 0) | (Has(x, y + 1) ? 8 : 0);
    const std::int32_t sides[4] = {Midway(x, y, false), Midway(x + 1, y, true),
                                   Midway(x, y + 1, false), Midway(x, y, true)};
    for (const Passage& passage : kPassages[static_cast<std::size_t>(corners)]) {
      if (passage.from != kNoSide)
        next_[static_cast<std::size_t>(sides[passage.from])] = sides[passage.to];
    }
  }

  // Appends p, and drops the corner before it if the border runs straight on there.
  static void Append(Polygon& loop, const Vector2& p) {
    const std::size_t n = loop.size();
    if (n >= 2) {
      const Vector2 a = loop[n - 1] - loop[n - 2], b = p - loop[n - 1];
      if (a.x() * b.y() == a.y() * b.x() && a.dot(b) > 0) loop.pop_back();
    }
    loop.push_back(p);
  }

  const CellMask& mask_;
  int width_, height_;
  std::vector<std::int32_t> next_;  // per midway place: the next one along the border
};

// Appends the corners of ring[first .. last) that Douglas and Peucker keep; always the first.
void AppendKept(const Polygon& ring, std::size_t first, std::size_t last, double tolerance,
                Polygon& kept) {
  const Vector2 &a = ring[first], &b = ring[last % ring.size()];
  std::size_t farthest = first;
  double distance = tolerance;
  for (std::size_t k = first + 1; k < last; ++k) {
    const double d = (NearestOnSegment(a, b, ring[k]) - ring[k]).norm();
    if (d > distance) distance = d, farthest = k;
  }
  if (farthest == first) {
    kept.push_back(a);
    return;
  }
  AppendKept(ring, first, farthest, tolerance, kept);
  AppendKept(ring, farthest, last, tolerance, kept);
}

// A ring has no ends, so it is divided at its corner of lowest x and the one farthest from that.
Polygon SimplifiedRing(Polygon ring, double tolerance) {
  std::rotate(ring.begin(),
              std::min_element(ring.begin(), ring.end(),
                               [](const Vector2& a, const Vector2& b) {
                                 return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
                               }),
              ring.end());
  std::size_t opposite = 0;
  for (std::size_t k = 1; k < ring.size(); ++k) {
    if ((ring[k] - ring[0]).squaredNorm() > (ring[opposite] - ring[0]).squaredNorm()) opposite = k;
  }
  Polygon kept;
  AppendKept(ring, 0, opposite, tolerance, kept);
  AppendKept(ring, opposite, ring.size(), tolerance, kept);
  return kept;
}

Outline SimplifiedTo(const Outline& outline, double tolerance) {
  Outline out{SimplifiedRing(outline.border, tolerance), {}};
  for (const Polygon& hole : outline.holes) {
    Polygon simpler = SimplifiedRing(hole, tolerance);
    // A hole thinner than the tolerance is dropped.
    if (simpler.size() >= 3 && SignedArea_m2(simpler) < 0) out.holes.push_back(std::move(simpler));
  }
  return out;
}

}  // namespace

std::size_t Outline::corner_count() const {
  std::size_t count = border.size();
  for (const Polygon& hole : holes) count += hole.size();
  return count;
}

Outline TraceOutline(const CellMask& mask) {
  Outline outline;
  for (Polygon& loop : Tracer(mask).Loops()) {
    if (SignedArea_m2(loop) > 0) {
      outline.border = std::move(loop);
    } else {
      outline.holes.push_back(std::move(loop));
    }
  }
  return outline;
}

Outline Simplified(Outline outline, const SimplifyLimits& limits) {
  if (outline.border.empty()) return outline;
  std::stable_sort(outline.holes.begin(), outline.holes.end(), [](const auto& a, const auto& b) {
    return std::abs(SignedArea_m2(a)) > std::abs(SignedArea_m2(b));
  });
  for (;; outline.holes.pop_back()) {
    for (const double step : kToleranceSteps) {
      Outline simpler = SimplifiedTo(outline, step * limits.tolerance);
      if (simpler.corner_count() <= limits.max_corners &&
          IsSimpleRegion(simpler.border, simpler.holes)) {
        return simpler;
      }
    }
    if (outline.holes.empty()) break;
  }
  Polygon hull = ConvexHull(outline.border);
  for (double tolerance = limits.tolerance; hull.size() > limits.max_corners; tolerance *= 1.5) {
    hull = SimplifiedRing(hull, tolerance);  // simplified hulls stay convex
  }
  return {std::move(hull), {}};
}

}  // namespace cwm::perception
