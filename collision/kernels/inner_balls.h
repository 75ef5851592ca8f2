// Balls in the solid of a closed mesh: whatever comes near enough to one of their centres overlaps it.
#pragma once

#include <span>
#include <vector>

#include "collision/kernels/triangle_tree.h"

namespace cwm::collision {

struct InnerBall {
  Vector3 centre = Vector3::Zero();
  double radius_m = 0;
};

// No more than kMostInnerBalls, the largest first, the others where most is left over. No triangle is
// nearer to a centre than the radius and `spared_m`. Of a mesh whose solid is thin there may be none.
// Some milliseconds.
inline constexpr std::size_t kMostInnerBalls = 12;
std::vector<InnerBall> InnerBallsOf(const TriangleTree& tree, double spared_m,
                                    WorkCounter* work = nullptr);

// Whether two sets of balls, in the frames of A and B, overlap anywhere.
bool BallsOverlap(std::span<const InnerBall> a, std::span<const InnerBall> b, const Pose& X_AB);

}  // namespace cwm::collision
