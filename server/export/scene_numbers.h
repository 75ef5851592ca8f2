// Formats numbers and texts for planning scenes.
#pragma once

#include <string>

#include "collision/geometry/pose.h"

namespace cwm::server {

// The shortest text that reads back as the same double in C++ and in YAML 1.1, which takes "1e-05"
// for a string and "1.0e-05" for a number.
std::string NumberText(double value);

// "x<separator>y<separator>z".
std::string Text(const Vector3& vector, const char* separator);
// The rotation as x, y, z, w with w >= 0.
std::string RotationText(const Pose& pose, const char* separator);

// The text in double quotes, so that no name is taken for a number, a boolean or a null.
std::string Quoted(const std::string& text);

}  // namespace cwm::server
