// Estimates the memory of a prepared robot while its files are read.
#pragma once

#include <cstddef>

#include "absl/status/status.h"
#include "collision/geometry/shape.h"
#include "collision/robot/robot_limits.h"

namespace cwm::collision {

// Every byte of the files allows a number of bytes of memory; links, shapes and triangles take some
// each. This refuses small files that become large: scaled copies of a mesh, thousands of links, a
// mesh used by many links. The estimates are upper bounds, within a factor of two of what is kept.
// The limits must outlive the budget.
class PreparedBudget {
 public:
  explicit PreparedBudget(const RobotLimits& limits) : limits_(limits) {}

  void AddFile(std::size_t bytes) { file_bytes_ += bytes; }

  // Each function takes memory before it is allocated. RESOURCE_EXHAUSTED if the files read so far
  // do not allow that much.
  absl::Status TakeLinks(std::size_t links);
  // Takes the next shape of a link that already has `shapes_before`. The first one pairs the link
  // with all other links with shapes.
  absl::Status TakeShape(const Shape& shape, std::size_t shapes_before);
  // Takes a mesh at a scale of which there is no copy yet.
  absl::Status TakeTriangles(std::size_t triangles);

 private:
  absl::Status Take(std::size_t bytes);

  const RobotLimits& limits_;
  std::size_t file_bytes_ = 0;
  std::size_t taken_bytes_ = 0;
  std::size_t shaped_links_ = 0;
};

}  // namespace cwm::collision
