// Where the search for a whole solid starts.
#pragma once

#include <vector>

#include "perception/whole/whole_kind.h"

namespace cwm::perception {

// chosen: radii, how long what hides behind an end in view may be: of what is round and lies or
// leans its end may be nearly all that is seen.
inline constexpr double kHiddenRadii = 3;

// Points of an object in the frame of the ground.
struct PointsOnGround {
  Pose X_MG = Pose::Identity();
  Vector3 viewpoint_G = Vector3::Zero();
  std::vector<Vector3> p_G;
  std::vector<double> sigma_m;
};

// What the extents and circles of the points suggest, and what is known of this kind.
std::vector<WholeParameters> StartsOf(WholeKind kind, const std::vector<Solid>& known,
                                      const PointsOnGround& points);

}  // namespace cwm::perception
