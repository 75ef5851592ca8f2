// Grasps of an object of the world: of each of its parts and handles.
#pragma once

#include "clients/grasp/sample_shape.h"
#include "cwm/v1/world.pb.h"

namespace cwm::grasp {

Eigen::Isometry3d ToIsometry(const cwm::v1::Pose& pose);

// Frame F of the candidates is the world. Parts whose surface has no closed form (convex hulls,
// meshes, plates) and objects that have surfaces alone are taken by the boxes around them, as
// handles are: what the pads really meet has to be asked. `up_S` of the options does not count.
Candidates SampleObject(const cwm::v1::Object& object, const SamplerOptions& options);

}  // namespace cwm::grasp
