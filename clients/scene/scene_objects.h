// Objects of a planning scene as those of a world.
#pragma once

#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "clients/formats/scene_file.h"
#include "cwm/v1/world.pb.h"

namespace cwm::scene {

cwm::v1::Pose ToProto(const formats::ScenePose& pose);

// The name that an object of this id gets in the world: the id, each byte but letters, digits and
// "_-./" an underscore.
std::string WorldName(const std::string& id);

// Stores a mesh with the server; its hash.
using StoreMesh = std::function<absl::StatusOr<std::string>(const formats::MeshFile&)>;

// An object of one shape whose own pose is the identity gets the shape's, so that moving it does
// what one expects. Planes are half-spaces; meshes are stored.
absl::StatusOr<cwm::v1::Object> ToObject(const formats::SceneObject& scene_object,
                                         const StoreMesh& store);

}  // namespace cwm::scene
