// Grasp candidates for an object of the world: for each of its parts and handles.
#pragma once

#include "clients/grasp/sample_shape.h"
#include "cwm/objects.h"

namespace cwm::grasp {

// Frame F of the candidates is the world. For parts whose surface has no closed form (convex hulls,
// meshes, plates), objects with only surfaces, and handles, the boxes around them are sampled: the
// true contacts must be checked. `up_S` of the options is ignored.
Candidates SampleObject(const api::Object& object, const SamplerOptions& options);

}  // namespace cwm::grasp
