// Start values of the fit of a closed solid.
#pragma once

#include <vector>

#include "perception/primitive_fit/primitive_kind.h"

namespace cwm::perception {

// chosen: in radii, the longest hidden part that is assumed behind an end in view. An end may be
// nearly all that is seen of a round solid that lies or leans.
inline constexpr double kHiddenRadii = 3;

// Points of an object in the frame of the ground.
struct PointsOnGround {
  Pose X_MG = Pose::Identity();
  Vector3 viewpoint_G = Vector3::Zero();
  std::vector<Vector3> p_G;
  std::vector<double> sigma_m;
};

// Start values that the extents and circles of the points suggest, and those of the known solids
// that are of this kind.
std::vector<PrimitiveParameters> StartsOf(PrimitiveKind kind, const std::vector<Solid>& known,
                                          const PointsOnGround& points);

}  // namespace cwm::perception
