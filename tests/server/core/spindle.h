// A mesh of any number of triangles.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "collision/geometry/triangle_mesh.h"

namespace cwm::server {

// A closed mesh of 2 * `sides` triangles.
inline TriangleMesh Spindle(std::uint32_t sides) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 1}, {0, 0, -1}};
  for (std::uint32_t i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    mesh.vertices.emplace_back(std::cos(angle), std::sin(angle), 0);
    const std::uint32_t a = 2 + i, b = 2 + (i + 1) % sides;
    mesh.triangles.push_back({0, a, b});
    mesh.triangles.push_back({1, b, a});
  }
  return mesh;
}

}  // namespace cwm::server
