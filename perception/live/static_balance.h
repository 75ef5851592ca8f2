// Tells things that can rest where they are from those that something holds.
#pragma once

#include <Eigen/Core>
#include <span>

#include "perception/live/frame_evidence.h"

namespace cwm::perception {

// True unless the frame shows that a thing above a support would fall. A rigid body at rest on level
// contacts has its centre of mass over their convex hull (static equilibrium; Mason, Mechanics of
// Robotic Manipulation, section 6.5). A column of the thing, a square of its footprint, has no
// contact if rays pass between it and the support; one that hides its foot, or whose foot is hidden,
// may have. The mean of the footprint stands for the centre of mass.
//
// `points_L`: of the thing, in the level frame L of the frame. `X_WS`: the support, whose top face
// is z = 0.
bool MayRest(std::span<const Eigen::Vector3f> points_L, const Pose& X_WS,
             const FrameEvidence& frame);

}  // namespace cwm::perception
