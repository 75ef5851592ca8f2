// What the readers of both formats of planning scenes check and build alike.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clients/formats/scene_file.h"

namespace cwm::formats {

// Dimensions in the order of shape_msgs/SolidPrimitive.
struct PrimitiveKind {
  const char* name;
  int number;  // of shape_msgs/SolidPrimitive
  std::size_t dimension_count;
};

// By name ("box") or number ("1"); nullptr for another word.
const PrimitiveKind* FindPrimitive(std::string_view word);

// `dimensions_m`: as many as the kind has, positive.
decltype(SceneShape::shape) MakePrimitive(const PrimitiveKind& kind,
                                          const std::vector<double>& dimensions_m);

// What a number breaks: not finite, or beyond kLargestSceneNumber. Nothing when it is fine.
std::optional<std::string> NumberFault(std::string_view word, double& value);

// Nothing when the length is within 1 % of 1: scenes written with two or three decimals are off by
// up to half a percent, more is a mistake. Normalises then.
std::optional<std::string> Normalise(std::array<double, 4>& orientation_xyzw);

// Drops triangles that use a vertex twice, which are no part of a surface; how many.
std::size_t DropDegenerate(MeshFile& mesh);

}  // namespace cwm::formats
