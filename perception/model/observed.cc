#include "perception/model/observed.h"

#include <algorithm>
#include <cmath>

#include "collision/geometry/tessellate.h"
#include "perception/cloud/voxel_grid.h"

namespace cwm::perception {
namespace {

constexpr double kDeviation_m = 1e-3;   // of the tessellation
constexpr int kMostSamplesAcross = 40;  // of a triangle: bounds the work on large faces

bool HasNeighbour(const VoxelGrid& grid, const VoxelGrid::Cell& cell) {
  return grid.Find(cell) != VoxelGrid::kNone ||  // the likeliest first
         grid.AnyWithin(1, cell, [](std::size_t) { return true; });
}

}  // namespace

double ObservedFraction(const Shape& shape, std::span<const Eigen::Vector3f> points_S,
                        double cell_m) {
  if (points_S.empty()) return 0;
  const VoxelGrid grid = VoxelGrid::Build(points_S, static_cast<float>(cell_m));
  // The grid's cells in the shape's frame: its first cell tells where they lie.
  const Eigen::Vector3f origin =
      grid.Center(0) - grid.edge_m() * (grid.cell(0).cast<float>().array() + 0.5f).matrix();
  const TriangleMesh mesh = Tessellate(shape, kDeviation_m);
  double area = 0, covered = 0;
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    const Vector3& a = mesh.vertices[t[0]];
    const Vector3 ab = mesh.vertices[t[1]] - a;
    const Vector3 ac = mesh.vertices[t[2]] - a;
    const double longest_m = std::max({ab.norm(), ac.norm(), (ab - ac).norm()});
    const int n =
        std::clamp(static_cast<int>(std::ceil(longest_m / cell_m)), 1, kMostSamplesAcross);
    // n^2 congruent triangles, one sample at the centroid of each.
    const double share = 0.5 * ab.cross(ac).norm() / (static_cast<double>(n) * n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < 2 * (n - i) - 1; ++j) {
        const int column = j / 2;
        const bool upside_down = j % 2 == 1;
        const double u = (i + (upside_down ? 2.0 : 1.0) / 3) / n;
        const double v = (column + (upside_down ? 2.0 : 1.0) / 3) / n;
        const Eigen::Vector3f q = ((a + u * ab + v * ac).cast<float>() - origin) / grid.edge_m();
        area += share;
        if (HasNeighbour(grid, q.array().floor().cast<int>().matrix())) covered += share;
      }
    }
  }
  return area > 0 ? covered / area : 0;
}

}  // namespace cwm::perception
