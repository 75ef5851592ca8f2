// A triangle mesh as in a file.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace cwm::formats {

// Coordinates are in metres; every index is below the number of vertices.
struct MeshFile {
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  friend bool operator==(const MeshFile&, const MeshFile&) = default;
};

}  // namespace cwm::formats
