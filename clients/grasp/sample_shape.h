// Grasps of one shape each, in the shape's frame S: lines along which pads can close on two opposite
// places of its surface, and around each line the directions to come from. Nothing is asked about
// what else is there.
#pragma once

#include "clients/grasp/candidate.h"
#include "clients/grasp/gripper.h"
#include "cwm/v1/geometry.pb.h"

namespace cwm::grasp {

struct SamplerOptions {
  Gripper gripper = {};
  double friction = 0.4;          // coefficient: walls may be tilted by its arc tangent
  double least_gap_m = 0.002;     // that is left of the opening on each side
  Eigen::Vector3d up_S{0, 0, 1};  // of the world: where to begin around round things
};

// Between opposite faces, slid along them, from each of the four edges between and from the corners.
Candidates SampleBox(const cwm::v1::Box& box, const SamplerOptions& options);
// Across the wall at heights along the axis; between the ends where those are near enough.
Candidates SampleCylinder(const cwm::v1::Cylinder& cylinder, const SamplerOptions& options);
// The same, by the width at each height and the tilt of the wall.
Candidates SampleCone(const cwm::v1::Cone& cone, const SamplerOptions& options);
Candidates SampleCapsule(const cwm::v1::Capsule& capsule, const SamplerOptions& options);
// Through the centre in every direction.
Candidates SampleSphere(const cwm::v1::Sphere& sphere, const SamplerOptions& options);
// One finger inside and one outside of the rim, from above; and the whole across its wall.
Candidates SampleVessel(const cwm::v1::Vessel& vessel, const SamplerOptions& options);
// Across a long thing of which only the box around it is known, from all sides: nearly every
// position has to be told from the mesh. `axis_B`: its length.
Candidates SampleHandle(const cwm::v1::Box& bounds, const Eigen::Vector3d& axis_B,
                        const SamplerOptions& options);

}  // namespace cwm::grasp
