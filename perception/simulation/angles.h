#pragma once

#include <numbers>

namespace cwm::perception {

constexpr double Radians(double degrees) { return degrees * std::numbers::pi / 180; }

}  // namespace cwm::perception
