// Random shapes in difficult poses: far, near, touching, overlapping, parallel, aligned. Numbers
// are drawn only in the order of statements and braced lists, so that every compiler makes the same
// pairs; C++ leaves the order of arguments and operands open.
#pragma once

#include <random>

#include "tests/collision/kernels/pair_oracle.h"

namespace cwm::collision {

class RandomPairs {
 public:
  // Dimensions are from 10^`min_exponent` to 10^`max_exponent` metres.
  explicit RandomPairs(unsigned seed, double min_exponent = -3, double max_exponent = 1)
      : random_(seed), min_exponent_(min_exponent), max_exponent_(max_exponent) {}

  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  int Index(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }

  // A random dimension: one in four log-uniform over the range, the others of the scale of the
  // pair.
  double Dimension();
  Shape ConvexShape(ShapeKind kind);
  Vector3 Direction();
  Vector3 VectorOfLength(double length);
  Matrix3 RotationBy(double angle_rad);  // about a random axis
  // A random rotation, one of the 24 of the cube, or one of these rotated by 1e-4 to 1e-14 rad.
  Matrix3 Rotation();
  Pose AnyPose(double reach_m);

  // A pair with A anywhere and B within twice the size of both, often aligned with A.
  PosedPair Pair(ShapeKind a, ShapeKind b);

  // A pair with dimensions of 5 to 20 cm, in random rotations, within 2 m of the origin.
  PosedPair HandSizedPair(ShapeKind a, ShapeKind b);

 private:
  std::mt19937_64 random_;
  double min_exponent_, max_exponent_;
  double scale_m_ = 1;
  bool all_alike_ = false;  // all dimensions are of the same scale
};

}  // namespace cwm::collision
