// Closed solids that stand, lie or lean on the ground, and their parameters.
#pragma once

#include <Eigen/Core>

#include "perception/fit/solid.h"

namespace cwm::perception {

enum class PrimitiveKind {
  kBall,             // x y z radius
  kUprightCylinder,  // x y height radius
  kUprightCone,      // x y height radius_top slope
  kLyingCylinder,    // x y yaw radius length
  kLyingCone,        // x y yaw radius_mid length slope; its lowest line touches
  kLeaningCylinder,  // x y yaw elevation radius length; its rim touches
  kUprightBox,       // x y yaw width depth height
  kTiltedBox,        // x y z, a rotation vector, width depth height
};

// The parameters listed with each kind, in metres and radians in the ground's frame G: z is up and
// the origin is on the ground. A slope is the growth of the radius per metre along the axis.
using PrimitiveParameters = Eigen::VectorXd;

bool IsConical(PrimitiveKind kind);
bool IsLying(PrimitiveKind kind);

// chosen: one standard deviation of a cone's slope. It puts half of all cups below a half angle of
// 6 degrees if nothing else constrains the slope.
inline constexpr double kSlopeSpread = 0.15;

// Smallest sine of a leaning axis' elevation, and smallest distance of that sine from 1. A solid
// nearer to level lies, and one nearer to upright stands.
// chosen: 3 degrees from level, 18 degrees from upright.
inline constexpr double kMinLean = 0.05;

// The slope of a cone, which is the last of its parameters; 0 for all other kinds.
double SlopeOf(PrimitiveKind kind, const PrimitiveParameters& x);

struct PlacedPrimitive {
  Pose X_GS = Pose::Identity();
  Shape shape;
};
PlacedPrimitive Place(PrimitiveKind kind, const PrimitiveParameters& x);

// The parameters of this kind for a solid that is of this kind or nearly so; empty for others. A
// lying solid may be slightly tilted, a cylinder becomes a cone without slope, and a cone becomes a
// cylinder of its mean radius.
std::optional<PrimitiveParameters> ParametersOf(PrimitiveKind kind, const PlacedPrimitive& solid);

}  // namespace cwm::perception
