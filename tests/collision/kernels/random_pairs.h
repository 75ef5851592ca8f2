// Random shapes in poses that hurt: far, near, kissing, sunk into each other, parallel, aligned.
// Draws are taken in the order of statements and of braced lists alone, so that every compiler
// makes the same pairs: C++ leaves the order of a call's arguments and of operands open.
#pragma once

#include <random>

#include "tests/collision/kernels/pair_oracle.h"

namespace cwm::collision {

class RandomPairs {
 public:
  // Dimensions from 10^`least` to 10^`most` metres.
  explicit RandomPairs(unsigned seed, double least = -3, double most = 1)
      : random_(seed), least_(least), most_(most) {}

  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  int Index(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }

  // Dimensions are spread evenly over the orders of magnitude, or all alike.
  double Dimension();
  Shape ConvexShape(ShapeKind kind);
  Vector3 Direction();
  Vector3 VectorOfLength(double length);
  Matrix3 RotationBy(double angle_rad);  // about any axis
  // Any rotation, one of the 24 of the cube, or one of these turned by 1e-4 to 1e-14 rad.
  Matrix3 Rotation();
  Pose AnyPose(double reach_m);

  // A is placed anywhere, B within twice of both sizes, often aligned with A.
  PosedPair Pair(ShapeKind a, ShapeKind b);

  // Shapes of which each dimension is 5 to 20 cm, any rotation, within 2 m of the origin.
  PosedPair HandSizedPair(ShapeKind a, ShapeKind b);

 private:
  std::mt19937_64 random_;
  double least_, most_;
  double scale_m_ = 1;
  bool all_alike_ = false;  // no dimension leaves the scale
};

}  // namespace cwm::collision
