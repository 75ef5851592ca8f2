// Grasp candidates for an object of the world: for each of its parts and handles.
#pragma once

#include "clients/grasp/sample_shape.h"
#include "cwm/v1/world.pb.h"

namespace cwm::grasp {

Eigen::Isometry3d ToIsometry(const cwm::v1::Pose& pose);

// Frame F of the candidates is the world. For parts whose surface has no closed form (convex hulls,
// meshes, plates), objects with only surfaces, and handles, the boxes around them are sampled: the
// true contacts must be checked. `up_S` of the options is ignored.
Candidates SampleObject(const cwm::v1::Object& object, const SamplerOptions& options);

}  // namespace cwm::grasp
