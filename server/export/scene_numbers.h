// Numbers and texts as the formats of planning scenes have them.
#pragma once

#include <string>

#include "collision/geometry/pose.h"

namespace cwm::server {

// The shortest text that reads back as the same double, in C++ and in YAML 1.1, which takes "1e-05"
// for a word and "1.0e-05" for a number.
std::string NumberText(double value);

// "x<separator>y<separator>z".
std::string Text(const Vector3& vector, const char* separator);
// The rotation as x, y, z, w, w not negative.
std::string RotationText(const Pose& pose, const char* separator);

// In double quotes, so that no name is taken for a number, a truth value or a null.
std::string Quoted(const std::string& text);

}  // namespace cwm::server
