// Poses as planning scenes write them.
#pragma once

#include <array>

namespace cwm::formats {

// Of one frame in another. Metres; the quaternion is of unit length.
struct ScenePose {
  std::array<double, 3> position_m = {0, 0, 0};
  std::array<double, 4> orientation_xyzw = {0, 0, 0, 1};
  friend bool operator==(const ScenePose&, const ScenePose&) = default;
};

bool IsIdentity(const ScenePose& pose);

// X_AC of X_AB and X_BC. Where one of the two is the identity, the other as it is, bit by bit.
ScenePose Composed(const ScenePose& x_a_b, const ScenePose& x_b_c);

// The frame whose plane z = 0 is a x + b y + c z + d = 0 and whose z axis is the side where that is
// positive. The normal (a, b, c) is of any length but 0.
ScenePose FrameOfPlane(const std::array<double, 4>& abcd);

}  // namespace cwm::formats
