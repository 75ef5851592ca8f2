#include "collision/robot/prepared_budget.h"

#include <algorithm>
#include <variant>

#include "absl/strings/str_cat.h"

namespace cwm::collision {
namespace {

// measured: the memory of a prepared robot with many of each, divided by their number.
constexpr std::size_t kLinkBytes = 600;
constexpr std::size_t kShapeBytes = 4'200;   // with a sphere around it
constexpr std::size_t kTriangleBytes = 340;  // with its vertices and the kernels' tree
constexpr std::size_t kSphereBytes = 1'750;  // one of the spheres around a link
constexpr std::size_t kMaxLinkSpheres = 32;  // kMaxSpheres of spheres/bounding_spheres.h
constexpr std::size_t kLinkPairBytes = 8;    // LinkPair
// Fitting spheres to a link visits the triangles of its meshes, up to this many. The work takes no
// memory, but is counted as if it took this much per triangle.
constexpr std::size_t kMaxSeenTriangles = 20'000;
constexpr std::size_t kSeenTriangleBytes = 16;

}  // namespace

absl::Status PreparedBudget::TakeLinks(std::size_t links) { return Take(links * kLinkBytes); }

absl::Status PreparedBudget::TakeShape(const Shape& shape, std::size_t shapes_before) {
  std::size_t bytes = kShapeBytes;
  if (shapes_before == 0) {
    bytes += kLinkPairBytes * shaped_links_++;
    if (!std::holds_alternative<Sphere>(shape)) bytes += kMaxLinkSpheres * kSphereBytes;
  }
  if (const Mesh* mesh = std::get_if<Mesh>(&shape)) {
    bytes += kSeenTriangleBytes * std::min(mesh->mesh->triangles.size(), kMaxSeenTriangles);
  }
  return Take(bytes);
}

absl::Status PreparedBudget::TakeTriangles(std::size_t triangles) {
  return Take(triangles * kTriangleBytes);
}

absl::Status PreparedBudget::Take(std::size_t bytes) {
  taken_bytes_ += bytes;
  const std::size_t limit_bytes =
      limits_.max_free_prepared_bytes + limits_.max_prepared_per_byte * file_bytes_;
  if (taken_bytes_ <= limit_bytes) return absl::OkStatus();
  return absl::ResourceExhaustedError(absl::StrCat(
      "the robot would take ", taken_bytes_, " bytes once it is prepared, must take at most ",
      limit_bytes, ": ", limits_.max_free_prepared_bytes, " and ", limits_.max_prepared_per_byte,
      " for each of the ", file_bytes_, " bytes of its files that were read"));
}

}  // namespace cwm::collision
