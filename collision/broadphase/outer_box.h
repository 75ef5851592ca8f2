// A box around a box, in half the bytes.
#pragma once

#include <cmath>
#include <limits>

#include "collision/geometry/aabb.h"

namespace cwm::collision {

// In single precision, each side rounded away from what is inside: what holds for it from outside
// (nothing nearer than so much) holds for all that it was made of.
class OuterBox {
 public:
  OuterBox() = default;  // empty
  // Around a box that is bounded and not empty, within the range of a float.
  explicit OuterBox(const Aabb& box)
      : bounds_(box.min().unaryExpr([](double x) { return RoundedDown(x); }),
                box.max().unaryExpr([](double x) { return -RoundedDown(-x); })) {}

  static OuterBox Around(const OuterBox& a, const OuterBox& b) {
    OuterBox both;
    both.bounds_ = a.bounds_.merged(b.bounds_);
    return both;
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
