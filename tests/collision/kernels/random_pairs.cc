#include "tests/collision/kernels/random_pairs.h"

#include <cmath>
#include <memory>
#include <numbers>

namespace cwm::collision {

double RandomPairs::Dimension() {
  // One dimension in four is independent of the scale: needles and sheets.
  if (all_alike_) return Uniform(0.05, 0.2);
  if (Index(4) == 0) return std::pow(10, Uniform(min_exponent_, max_exponent_));
  return scale_m_ * Uniform(0.2, 1);
}

Vector3 RandomPairs::Direction() {
  std::normal_distribution<double> normal;
  Vector3 v;
  do v = Vector3{normal(random_), normal(random_), normal(random_)};
  while (!(v.norm() > 1e-3));
  return v.normalized();
}

Vector3 RandomPairs::VectorOfLength(double length) { return length * Direction(); }

Matrix3 RandomPairs::RotationBy(double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, Direction()).toRotationMatrix();
}

Matrix3 RandomPairs::Rotation() {
  const Matrix3 any = RotationBy(Uniform(0, std::numbers::pi));
  const int style = Index(3);
  if (style == 0) return any;
  Matrix3 cube = Matrix3::Zero();
  const int x = Index(3), y = (x + 1 + Index(2)) % 3;
  cube(x, 0) = Index(2) == 0 ? 1 : -1;
  cube(y, 1) = Index(2) == 0 ? 1 : -1;
  cube.col(2) = cube.col(0).cross(cube.col(1));
  if (style == 1) return cube;
  return cube * RotationBy(std::pow(10, Uniform(-14, -4)));
}

Pose RandomPairs::AnyPose(double reach_m) {
  Pose pose = Pose::Identity();
  pose.linear() = Rotation();
  pose.translation() = VectorOfLength(Uniform(0, reach_m));
  return pose;
}

Shape RandomPairs::ConvexShape(ShapeKind kind) {
  switch (kind) {
    case ShapeKind::kSphere:
      return Sphere{Dimension()};
    case ShapeKind::kBox:
      return Box{{Dimension(), Dimension(), Dimension()}};
    case ShapeKind::kCylinder:
      return Cylinder{Dimension(), Dimension()};
    case ShapeKind::kCone: {
      Cone cone{Dimension(), Dimension(), Dimension()};
      if (Index(2) == 0) (Index(2) == 0 ? cone.radius_bottom_m : cone.radius_top_m) = 0;
      return cone;
    }
    case ShapeKind::kCapsule:
      return Capsule{Dimension(), Dimension()};
    case ShapeKind::kConvex: {
      std::vector<Vector3> points;
      const Vector3 size{Dimension(), Dimension(), Dimension()};
      for (int i = 5 + Index(20); i > 0; --i) points.push_back(size.cwiseProduct(Direction()));
      return Convex{std::make_shared<const TriangleMesh>(ConvexHull3(points))};
    }
    case ShapeKind::kPlate: {
      const double x = Dimension(), y = Dimension();
      return Plate{{{0, 0}, {x, 0}, {x, y}, {0, y}}, {}, Dimension()};
    }
    case ShapeKind::kHalfSpace:
    case ShapeKind::kMesh:
      break;
  }
  return HalfSpace{};
}

PosedPair RandomPairs::Pair(ShapeKind a, ShapeKind b) {
  scale_m_ = std::pow(10, Uniform(min_exponent_, max_exponent_));
  PosedPair pair{ConvexShape(a), ConvexShape(b)};
  pair.X_FA = AnyPose(10);
  pair.X_FB = Pose::Identity();
  const double size =
      a == ShapeKind::kHalfSpace || b == ShapeKind::kHalfSpace ? 1 : SizeOf({pair.a, pair.b}) / 6;
  Pose X_AB = AnyPose(2 * size);
  // Offsets along the axes of A, or no offset, make faces and axes meet.
  const int style = Index(4);
  if (style == 0) {
    const int axis = Index(3);
    X_AB.translation() = Uniform(-1, 1) * size * Vector3::Unit(axis);
  }
  if (style == 1 && Index(3) == 0) X_AB.translation().setZero();
  pair.X_FB = pair.X_FA * X_AB;
  return pair;
}

PosedPair RandomPairs::HandSizedPair(ShapeKind a, ShapeKind b) {
  all_alike_ = true;
  PosedPair pair{ConvexShape(a), ConvexShape(b)};
  all_alike_ = false;
  pair.X_FA = AnyPose(2);
  pair.X_FB = AnyPose(2);
  return pair;
}

}  // namespace cwm::collision
