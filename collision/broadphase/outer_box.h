// A conservative bounding box in single precision, half the size of an Aabb.
#pragma once

#include <cmath>
#include <limits>

#include "collision/geometry/aabb.h"

namespace cwm::collision {

// Each side is rounded outwards. A lower bound on the distance from this box is therefore a lower
// bound on the distance from the box that it was made of.
class OuterBox {
 public:
  OuterBox() = default;  // empty
  // `box` is bounded, not empty, and within the range of a float.
  explicit OuterBox(const Aabb& box)
      : bounds_(box.min().unaryExpr([](double x) { return RoundedDown(x); }),
                box.max().unaryExpr([](double x) { return -RoundedDown(-x); })) {}

  static OuterBox Merged(const OuterBox& a, const OuterBox& b) {
    OuterBox merged;
    merged.bounds_ = a.bounds_.merged(b.bounds_);
    return merged;
  }

  Aabb aabb() const { return bounds_.cast<double>(); }

 private:
  static float RoundedDown(double x) {
    const auto nearest = static_cast<float>(x);
    return static_cast<double>(nearest) <= x
               ? nearest
               : std::nextafter(nearest, -std::numeric_limits<float>::infinity());
  }

  Eigen::AlignedBox3f bounds_;
};

}  // namespace cwm::collision
