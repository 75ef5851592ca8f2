// Closed solids that stand or lie on the ground as a whole, by their parameters.
#pragma once

#include <Eigen/Core>

#include "perception/fit/solid.h"

namespace cwm::perception {

enum class WholeKind {
  kBall,             // x y z radius
  kUprightCylinder,  // x y height radius
  kUprightCone,      // x y height radius_top slope
  kLyingCylinder,    // x y yaw radius length
  kLyingCone,        // x y yaw radius_mid length slope, touching along its lowest line
  kLeaningCylinder,  // x y yaw elevation radius length, touching with the lowest place of its rim
  kUprightBox,       // x y yaw width depth height
  kTiltedBox,        // x y z, a rotation vector, width depth height
};

// As listed with the kinds; metres and radians in the frame G of the ground, whose z is up and
// whose origin is on the ground. Slopes are the growth of the radius per metre along the axis.
using WholeParameters = Eigen::VectorXd;

bool IsConical(WholeKind kind);
bool Lies(WholeKind kind);

// chosen: one standard deviation; half of the cups have half angles below 6 degrees where nothing
// tells.
inline constexpr double kSlopeSpread = 0.15;

// Sine of the elevation of what leans, and its distance from 1: nearer to level it lies, nearer to
// upright it stands.
// chosen: 3 degrees from level, 18 degrees from upright.
inline constexpr double kMinLean = 0.05;

// Of a cone, the last of its parameters; 0 of all others.
double SlopeOf(WholeKind kind, const WholeParameters& x);

struct WholeSolid {
  Pose X_GS = Pose::Identity();
  Shape shape;
};
WholeSolid Place(WholeKind kind, const WholeParameters& x);

// The parameters of a solid that is of this kind, or nearly: a lying one may be tilted, a cylinder
// is a cone without slope and a cone a cylinder of its mean radius.
std::optional<WholeParameters> ParametersOf(WholeKind kind, const WholeSolid& solid);

}  // namespace cwm::perception
