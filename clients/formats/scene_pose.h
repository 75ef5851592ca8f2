// Poses of planning scenes.
#pragma once

#include <array>

namespace cwm::formats {

// The pose of one frame in another, in metres; the quaternion has unit length.
struct ScenePose {
  std::array<double, 3> position_m = {0, 0, 0};
  std::array<double, 4> orientation_xyzw = {0, 0, 0, 1};
  friend bool operator==(const ScenePose&, const ScenePose&) = default;
};

bool IsIdentity(const ScenePose& pose);

// X_AC from X_AB and X_BC. If one of them is the identity, returns the other bit by bit.
ScenePose ComposePoses(const ScenePose& x_a_b, const ScenePose& x_b_c);

// The frame whose plane z = 0 is a x + b y + c z + d = 0 and whose z axis points to its positive
// side. The normal (a, b, c) may have any length but 0.
ScenePose PlaneFrame(const std::array<double, 4>& abcd);

}  // namespace cwm::formats
