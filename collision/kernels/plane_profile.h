// A plane figure, which is the outline of a plate or the profile of a solid of revolution: signed
// distances of points in the plane, their gradients and their kinks (kink.h).
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
  // The profile through points (radial, z) that start and end on the axis, with the solid on the
  // left. The axis is not part of the border. Points may coincide.
  static PlaneProfile Revolved(std::span<const Vector2> points);
  // The outline and the holes of a plate.
  static PlaneProfile Outline(const Plate& plate);

  const std::vector<ProfileEdge>& edges() const { return edges_; }

  PlaneSample Sample(const Vector2& p) const;

 private:
  struct Projection {
    double way = 0;                    // position along the edge's line, in 0..1 on the edge
    Vector2 offset = Vector2::Zero();  // from the nearest point of the edge to the query point
    double distance_m = 0;
  };
  void AddChain(std::span<const Vector2> points, bool closed, bool solid_on_left);
  static double ParameterOf(const ProfileEdge& edge, const Vector2& p);
  static Projection ProjectOn(const ProfileEdge& edge, const Vector2& p);
  // True if no neighbouring point of the border is nearer than the projection. A corner counts
  // once, for the edge that begins there.
  bool IsLocallyNearest(const ProfileEdge& edge, const Projection& projection,
                        const Vector2& p) const;
  bool IsKink(const Vector2& p, const PlaneSample& nearest, double sign) const;
  Vector2 GradientAt(const ProfileEdge& edge, const Projection& projection, double sign) const;

  std::vector<ProfileEdge> edges_;
  double size_m_ = 0;
};

}  // namespace cwm::collision
