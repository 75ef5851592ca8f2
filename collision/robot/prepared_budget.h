// What a robot will take once it is prepared, counted while its files are read.
#pragma once

#include <cstddef>

#include "absl/status/status.h"
#include "collision/geometry/shape.h"
#include "collision/robot/robot_limits.h"

namespace cwm::collision {

// Each file that is read allows some bytes; each link, shape and triangle takes some. Refused is what
// makes a small file large: scaled copies of a mesh, thousands of links, a mesh that many links name.
// The estimates are upper bounds of what is kept, to the nearest factor of two. The limits must
// outlive it.
class PreparedBudget {
 public:
  explicit PreparedBudget(const RobotLimits& limits) : limits_(limits) {}

  void AddFile(std::size_t bytes) { file_bytes_ += bytes; }

  // Each takes before anything is made, and refuses with RESOURCE_EXHAUSTED what is more than the
  // files that were read so far allow.
  absl::Status TakeLinks(std::size_t links);
  // The next shape of a link that has so many; the first one pairs the link with all others that
  // have shapes.
  absl::Status TakeShape(const Shape& shape, std::size_t shapes_before);
  // A mesh of which there is no copy at the same scale yet.
  absl::Status TakeTriangles(std::size_t triangles);

 private:
  absl::Status Take(std::size_t bytes);

  const RobotLimits& limits_;
  std::size_t file_bytes_ = 0;
  std::size_t taken_bytes_ = 0;
  std::size_t shaped_links_ = 0;
};

}  // namespace cwm::collision
