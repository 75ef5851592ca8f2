// How much of a mesh file is read before it is refused. The defaults bound the memory and the time
// that a hostile file can take; a caller who knows its files may widen them.
#pragma once

#include <cstddef>

namespace cwm::collision {

struct MeshFileLimits {
  // A binary STL of five million triangles fits.
  std::size_t max_bytes = std::size_t{256} << 20;
  // One Collada file, which takes up to forty times its size while read.
  std::size_t max_collada_bytes = std::size_t{64} << 20;
  std::size_t max_triangles = 5'000'000;  // half a GB while read
};

}  // namespace cwm::collision
