// Limits on a mesh file, beyond which it is refused. The defaults bound the memory and the time
// that a hostile file can take; a caller that trusts its files may raise them.
#pragma once

#include <algorithm>
#include <cstddef>

namespace cwm::collision {

struct MeshFileLimits {
  // chosen: a binary STL file of five million triangles fits.
  std::size_t max_bytes = std::size_t{256} << 20;
  // chosen: for a Collada file, which takes up to forty times its size while it is read.
  std::size_t max_collada_bytes = std::size_t{64} << 20;
  std::size_t max_triangles = 5'000'000;  // half a GB while read
  // A file may use one geometry many times, or define a triangle in two bytes. It may therefore
  // have max_free_triangles triangles plus one for each min_bytes_per_triangle of its bytes.
  // derived: a prepared triangle takes 340 bytes, so 12,000 take 4 MiB, and one for each 4 bytes
  // takes 85 times the file. Files written by tools have from 12 (GLB with short indices) to 250
  // (text) bytes per triangle.
  std::size_t max_free_triangles = 12'000;
  std::size_t min_bytes_per_triangle = 4;

  std::size_t MaxTrianglesOf(std::size_t bytes) const {
    return std::min(max_triangles, max_free_triangles + bytes / min_bytes_per_triangle);
  }
};

}  // namespace cwm::collision
