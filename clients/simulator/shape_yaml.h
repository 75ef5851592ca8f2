// Reads a shape in YAML: a map with one key that names its kind.
#pragma once

#include <array>
#include <string_view>

#include "clients/simulator/yaml_node.h"
#include "collision/geometry/shape.h"

namespace cwm::simulator {

// The keys that name a kind of shape.
inline constexpr std::array<std::string_view, 8> kShapeKeys = {
    "sphere", "box", "cylinder", "cone", "capsule", "plate", "half_space", "mesh"};

// The shape under `key`, one of kShapeKeys, of the map `node`. Mesh paths are relative to the
// folder of the document's file.
absl::StatusOr<Shape> ReadShape(const YamlNode& node, std::string_view key);

}  // namespace cwm::simulator
