// Grasp candidates for one shape, in the shape's frame S: lines along which pads can close on two
// opposite places of its surface, and for each line the approach directions around it. Other
// objects are ignored.
#pragma once

#include "clients/grasp/candidate.h"
#include "clients/grasp/gripper.h"
#include "cwm/objects.h"

namespace cwm::grasp {

struct SamplerOptions {
  Gripper gripper = {};
  double friction = 0.4;          // coefficient; walls may be tilted by its arc tangent
  double min_gap_m = 0.002;       // smallest gap between surface and pad, on each side
  Eigen::Vector3d up_S{0, 0, 1};  // of the world; first direction around round shapes
};

// Between opposite faces, shifted along them, from the four edges in between and from the corners.
Candidates SampleBox(const api::Box& box, const SamplerOptions& options);
// Across the wall at places along the axis; between the ends if they are close enough.
Candidates SampleCylinder(const api::Cylinder& cylinder, const SamplerOptions& options);
// The same, with the width at each height and the tilt of the wall.
Candidates SampleCone(const api::Cone& cone, const SamplerOptions& options);
Candidates SampleCapsule(const api::Capsule& capsule, const SamplerOptions& options);
// Through the centre in all directions.
Candidates SampleSphere(const api::Sphere& sphere, const SamplerOptions& options);
// One finger inside and one outside of the rim, from above; and across the whole wall.
Candidates SampleVessel(const api::Vessel& vessel, const SamplerOptions& options);
// Across a long object of which only the bounding box is known, from all sides; nearly every
// position must then be checked against the mesh. `axis_B`: its long axis.
Candidates SampleHandle(const api::Box& bounds, const Eigen::Vector3d& axis_B,
                        const SamplerOptions& options);

}  // namespace cwm::grasp
