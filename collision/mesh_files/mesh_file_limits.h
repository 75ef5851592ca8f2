// How much of a mesh file is read before it is refused. The defaults bound the memory and the time
// that a hostile file can take; a caller who knows its files may widen them.
#pragma once

#include <algorithm>
#include <cstddef>

namespace cwm::collision {

struct MeshFileLimits {
  // A binary STL of five million triangles fits.
  std::size_t max_bytes = std::size_t{256} << 20;
  // One Collada file, which takes up to forty times its size while read.
  std::size_t max_collada_bytes = std::size_t{64} << 20;
  std::size_t max_triangles = 5'000'000;  // half a GB while read
  // A file may use one geometry many times, or name a triangle in two bytes: it has so many
  // triangles at most, and one more for each so many of its bytes. derived: a prepared triangle takes
  // 340 bytes, so that 12,000 are 4 MiB and one for each 4 bytes is 85 times the file. Files that
  // tools write have 12 bytes a triangle (GLB with short indices) to 250 (text).
  std::size_t max_free_triangles = 12'000;
  std::size_t min_bytes_per_triangle = 4;

  std::size_t MaxTrianglesOf(std::size_t bytes) const {
    return std::min(max_triangles, max_free_triangles + bytes / min_bytes_per_triangle);
  }
};

}  // namespace cwm::collision
