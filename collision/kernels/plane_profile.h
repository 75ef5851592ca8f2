// A figure in the plane that is a solid's outline or the profile that makes it by revolution: the
// signed distance of points in the plane, with its gradient and where it has none.
#pragma once

#include <span>
#include <vector>

#include "collision/geometry/shape.h"
#include "collision/kernels/solid_lanes.h"

namespace cwm::collision {

struct PlaneSample {
  double distance_m = 0;                // negative inside
  Vector2 gradient = Vector2::UnitX();  // unit
  bool kink = false;
};

class PlaneProfile {
 public:
  // Of points (radial, z) from the axis to the axis, the solid on the left; the axis is no border.
  // Points may coincide.
  static PlaneProfile Revolved(std::span<const Vector2> points);
  // Outline and holes.
  static PlaneProfile Outline(const Plate& plate);

  const std::vector<ProfileEdge>& edges() const { return edges_; }

  PlaneSample Sample(const Vector2& p) const;

 private:
  struct Foot {
    double way = 0;                    // 0 to 1 on the edge
    Vector2 offset = Vector2::Zero();  // from the nearest point of the edge to the point that asks
    double distance_m = 0;
  };
  void AddChain(std::span<const Vector2> points, bool closed, bool solid_on_left);
  static double Way(const ProfileEdge& edge, const Vector2& p);
  static Foot FootOn(const ProfileEdge& edge, const Vector2& p);
  // Whether no place of the figure beside the foot is nearer; of a corner, only at the edge that
  // begins there.
  bool IsLocallyNearest(const ProfileEdge& edge, const Foot& foot, const Vector2& p) const;
  bool PullsTwoWays(const Vector2& p, const PlaneSample& nearest, double sign) const;
  Vector2 GradientAt(const ProfileEdge& edge, const Foot& foot, double sign) const;

  std::vector<ProfileEdge> edges_;
  double size_m_ = 0;
};

}  // namespace cwm::collision
