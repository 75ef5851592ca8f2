#include "collision/kernels/inner_spheres.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cwm::collision {
namespace {

// Cells of the box along each axis, whose middles are the candidate centres. measured: for a robot
// link, more cells find balls that are larger by a few percent only.
constexpr int kCells = 8;
// chosen: share of the largest ball's radius. A ball that sticks out of the others by less hardly
// helps.
constexpr double kMinGain = 0.1;

std::vector<InnerSphere> BallsAtCells(const TriangleTree& tree, double spared_m,
                                      WorkCounter* work) {
  std::vector<InnerSphere> balls;
  const Aabb& box = tree.bounds();
  const Vector3 cell = box.sizes() / kCells;
  for (int k = 0; k < kCells * kCells * kCells; ++k) {
    const Eigen::Vector3i at(k % kCells, k / kCells % kCells, k / (kCells * kCells));
    const Vector3 centre =
        box.min() + cell.cwiseProduct(at.cast<double>() + Vector3::Constant(0.5));
    if (MustEnd(work, kStepsPerContainmentTest)) break;
    if (!tree.Contains(centre, work)) continue;
    constexpr double kUnlimited_m = std::numeric_limits<double>::infinity();
    const double radius_m = tree.NearestPoint(centre, kUnlimited_m, work).distance_m - spared_m;
    if (radius_m > 0) balls.push_back({.centre = centre, .radius_m = radius_m});
  }
  return balls;
}

}  // namespace

std::vector<InnerSphere> FindInnerSpheres(const TriangleTree& tree, double spared_m,
                                          WorkCounter* work) {
  const std::vector<InnerSphere> all = BallsAtCells(tree, spared_m, work);
  // The length by which each ball sticks out of those already taken.
  std::vector<double> gain_m;
  for (const InnerSphere& ball : all) gain_m.push_back(ball.radius_m);
  std::vector<InnerSphere> taken;
  while (!all.empty() && taken.size() < kMaxInnerSpheres) {
    const auto best = std::ranges::max_element(gain_m);
    const InnerSphere& next = all[static_cast<std::size_t>(best - gain_m.begin())];
    if (!taken.empty() && *best < kMinGain * taken.front().radius_m) break;
    taken.push_back(next);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const double out_m = (all[k].centre - next.centre).norm() + all[k].radius_m - next.radius_m;
      gain_m[k] = std::min(gain_m[k], out_m);
    }
  }
  return taken;
}

bool SpheresOverlap(std::span<const InnerSphere> a, std::span<const InnerSphere> b,
                    const Pose& X_AB) {
  return std::ranges::any_of(b, [&](const InnerSphere& of_b) {
    const Vector3 centre = X_AB * of_b.centre;
    return std::ranges::any_of(a, [&](const InnerSphere& of_a) {
      const double radii_m = of_a.radius_m + of_b.radius_m;
      return (of_a.centre - centre).squaredNorm() < radii_m * radii_m;
    });
  });
}

}  // namespace cwm::collision
