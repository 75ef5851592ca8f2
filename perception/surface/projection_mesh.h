// Smooths by moving least squares and triangulates by an advancing front of local projections: the
// only file that calls PCL.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "perception/cloud/work.h"

namespace cwm::perception {

struct ProjectionMesh {
  std::vector<Eigen::Vector3f> vertices;  // the given ones, smoothed; same number and order
  std::vector<std::array<std::uint32_t, 3>> triangles;  // any winding; may have slivers, repeats
};

// chosen: the radius of a vertex's neighbourhood, in spacings: about 30 vertices, five for each of
// the six coefficients of a quadric. An edge of this length bridges the gap of one missing vertex.
inline constexpr double kMaxEdge = 3;

// `vertices` are evenly spaced, about `spacing_m` apart. No vertex moves by more than the spacing,
// and no edge is longer than kMaxEdge spacings. No triangles for fewer than three vertices. Throws
// Stopped when `work` is stopped, also from within the library's loops.
ProjectionMesh MeshByProjection(const std::vector<Eigen::Vector3f>& vertices, double spacing_m,
                                const Work& work = {});

}  // namespace cwm::perception
