// Smoothing by moving least squares and triangulation by an advancing front of local projections:
// the only place that calls PCL.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "perception/cloud/work.h"

namespace cwm::perception {

struct ProjectionMesh {
  std::vector<Eigen::Vector3f> vertices;  // the given ones, smoothed; same number and order
  std::vector<std::array<std::uint32_t, 3>> triangles;  // as the front found them: of any winding,
                                                        // some of them slivers, possibly repeated
};

// chosen: how far the neighbours of a vertex reach, in spacings: some 30 vertices, five for each of
// the six coefficients of a quadric. An edge as long bridges the gap that one missing vertex
// leaves.
inline constexpr double kMaxEdge = 3;

// `vertices` are evenly spaced, about `spacing_m` apart. No vertex moves by more than the spacing.
// No edge is longer than kMaxEdge spacings. No triangles for fewer than three vertices.
// Throws Stopped when `work` is stopped, out of the middle of the library's loops.
ProjectionMesh MeshByProjection(const std::vector<Eigen::Vector3f>& vertices, double spacing_m,
                                const Work& work = {});

}  // namespace cwm::perception
