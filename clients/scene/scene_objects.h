// Converts objects of a planning scene to objects of a world.
#pragma once

#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "clients/formats/scene_file.h"
#include "cwm/v1/world.pb.h"

namespace cwm::scene {

cwm::v1::Pose ScenePoseToProto(const formats::ScenePose& pose);

// The name in the world of an object with this id: each byte but letters, digits and "_-./" becomes
// an underscore.
std::string ObjectName(const std::string& id);

// Stores a mesh on the server and returns its hash.
using StoreMesh = std::function<absl::StatusOr<std::string>(const formats::MeshFile&)>;

// An object of one shape whose own pose is the identity gets the shape's pose, so that moving it
// works as expected. Planes become half-spaces; meshes are stored.
absl::StatusOr<cwm::v1::Object> ConvertObject(const formats::SceneObject& scene_object,
                                              const StoreMesh& store);

}  // namespace cwm::scene
