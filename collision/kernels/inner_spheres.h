// Balls in the solid of a closed mesh. A shape that is nearer to a centre than the radius overlaps
// it.
#pragma once

#include <span>
#include <vector>

#include "collision/kernels/triangle_tree.h"

namespace cwm::collision {

struct InnerSphere {
  Vector3 centre = Vector3::Zero();
  double radius_m = 0;
};

// At most kMaxInnerSpheres balls: the largest first, then those that stick out most of the balls
// already taken. No triangle is nearer to a centre than the radius plus `spared_m`. Empty if the
// solid is too thin. Takes some milliseconds.
inline constexpr std::size_t kMaxInnerSpheres = 12;
std::vector<InnerSphere> FindInnerSpheres(const TriangleTree& tree, double spared_m,
                                          WorkCounter* work = nullptr);

// True if a ball of A and a ball of B overlap; each set is in its own frame.
bool SpheresOverlap(std::span<const InnerSphere> a, std::span<const InnerSphere> b,
                    const Pose& X_AB);

}  // namespace cwm::collision
