// Checks and constructors shared by the readers of both scene formats.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clients/formats/scene_file.h"

namespace cwm::formats {

// Dimensions in the order of shape_msgs/SolidPrimitive.
struct PrimitiveKind {
  const char* name;
  int number;  // in shape_msgs/SolidPrimitive
  std::size_t dimension_count;
};

// The kind by name ("box") or number ("1"); nullptr for other words.
const PrimitiveKind* FindPrimitive(std::string_view word);

// `dimensions_m` must have as many positive numbers as the kind requires.
decltype(SceneShape::shape) MakePrimitive(const PrimitiveKind& kind,
                                          const std::vector<double>& dimensions_m);

// The rule that a number violates: not finite, or beyond kMaxSceneNumber. Empty if it is valid.
std::optional<std::string> ParseSceneNumber(std::string_view word, double& value);

// Normalises the quaternion if its length is within 1 % of 1; otherwise returns the rule. Scenes
// written with two or three decimals are off by up to half a percent; more is an error.
std::optional<std::string> NormalizeQuaternion(std::array<double, 4>& orientation_xyzw);

// Drops triangles that use a vertex twice, which have no area; returns their number.
std::size_t RemoveDegenerateTriangles(MeshFile& mesh);

}  // namespace cwm::formats
