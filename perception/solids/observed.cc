#include "perception/solids/observed.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "collision/geometry/tessellate.h"
#include "perception/cloud/oriented_points.h"
#include "perception/cloud/voxel_grid.h"

namespace cwm::perception {
namespace {

// chosen: samples along each side of a triangle; bounds the work on large faces.
constexpr int kMaxSamplesAcross = 40;

// A triangle seen from the corner opposite its shortest side: tessellated solids have long, narrow
// triangles.
struct Sampled {
  Vector3 apex, to_first, to_second;
  double length_m = 0, width_m = 0, area_m2 = 0;

  // The point at these coordinates. Equal areas correspond to equal steps of along^2 and of across,
  // both between 0 and 1.
  Vector3 At(double along, double across) const {
    return apex + along * ((1 - across) * to_first + across * to_second);
  }
};

Sampled FromShortestSide(const TriangleMesh& mesh, const TriangleMesh::Triangle& t) {
  std::array<Vector3, 3> p = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
  const std::array<double, 3> across = {(p[1] - p[2]).norm(), (p[2] - p[0]).norm(),
                                        (p[0] - p[1]).norm()};
  std::rotate(p.begin(), p.begin() + (std::ranges::min_element(across) - across.begin()), p.end());
  const Vector3 to_first = p[1] - p[0], to_second = p[2] - p[0];
  return {.apex = p[0],
          .to_first = to_first,
          .to_second = to_second,
          .length_m = std::ranges::max(across),
          .width_m = std::ranges::min(across),
          .area_m2 = 0.5 * to_first.cross(to_second).norm()};
}

int CellsAlong(double length_m, double cell_m) {
  return std::clamp(static_cast<int>(std::ceil(length_m / cell_m)), 1, kMaxSamplesAcross);
}

bool HasNeighbour(const VoxelGrid& grid, const VoxelGrid::Cell& cell) {
  return grid.Find(cell) != kNoIndex ||  // the likeliest cell first
         grid.AnyWithin(1, cell, [](std::size_t) { return true; });
}

}  // namespace

double ObservedFraction(const Shape& shape, std::span<const Eigen::Vector3f> points_S,
                        double cell_m) {
  if (points_S.empty()) return 0;
  const VoxelGrid grid = VoxelGrid::Build(points_S, static_cast<float>(cell_m));
  // The corner of the grid in the shape's frame, from the centre of its first cell.
  const Eigen::Vector3f origin =
      grid.Center(0) - grid.edge_m() * (grid.cell(0).cast<float>().array() + 0.5f).matrix();
  // The tessellation deviates from the shape by no more than surfaces are uneven.
  const TriangleMesh mesh = Tessellate(shape, kUnevenness_m);
  double area = 0, covered = 0;
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    const Sampled triangle = FromShortestSide(mesh, t);
    const int rows = CellsAlong(triangle.length_m, cell_m);
    const int columns = CellsAlong(triangle.width_m, cell_m);
    const double share = triangle.area_m2 / (rows * columns);
    for (int i = 0; i < rows; ++i) {
      const double along = std::sqrt((i + 0.5) / rows);
      for (int j = 0; j < columns; ++j) {
        const Eigen::Vector3f q =
            (triangle.At(along, (j + 0.5) / columns).cast<float>() - origin) / grid.edge_m();
        area += share;
        if (HasNeighbour(grid, q.array().floor().cast<int>().matrix())) covered += share;
      }
    }
  }
  return area > 0 ? covered / area : 0;
}

}  // namespace cwm::perception
