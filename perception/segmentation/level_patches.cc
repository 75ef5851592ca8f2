#include "perception/segmentation/level_patches.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <numbers>

#include "perception/cloud/parallel_for.h"
#include "perception/cloud/tolerances.h"
#include "perception/cloud/voxel_grid.h"

namespace cwm::perception {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;

using namespace std::chrono_literals;

// derived: the largest deviation along up of a level cell, in edges. Points of an upright surface
// fill the cell, a deviation of 1 / sqrt(12). Half of that is more than a slope of kMaxTilt_rad and
// foreshortened noise make.
constexpr float kMaxHeight_cells = std::numbers::inv_sqrt3_v<float> / 4;
// derived: the largest deviation across a level plane; along it points spread by more than noise
// (kGate_sigma). The points of a wall of one cell's height spread by one sigma of noise along the
// wall's normal, and by more than two along up, as a cell is 8 sigma high. Those of a board spread
// along the board by six, over three cells; noise across the ray and warp lift them by about one.
constexpr float kMaxThickness_sigma = 1.5f;

float Square(float x) { return x * x; }

// The deviation along up, in metres.
float Height_m(const Moments& moments, const Vector3f& up) {
  return std::sqrt(std::max(0.0f, up.dot(moments.Covariance() * up)));
}

// True if the surface continues above the cell: a cell may hold no more than the foot of a wall.
// Half as many points above as in the cell are more than mixed pixels.
bool GoesOnAbove(const CoarseCloud& coarse, std::size_t c, const Vector3f& up) {
  const float edge_m = coarse.grid.edge_m();
  Moments column;
  std::size_t above = 0;
  coarse.grid.ForEachWithin(1, coarse.grid.cell(c), [&](std::size_t o) {
    const Vector3f away = coarse.grid.Center(o) - coarse.grid.Center(c);
    const float higher_m = up.dot(away);
    if (higher_m < -0.5f * edge_m || (away - higher_m * up).norm() > 0.5f * edge_m) return;
    column.Add(coarse.grid.moments(o), away);
    if (o != c) above += coarse.grid.PointsOf(o).size();
  });
  return static_cast<double>(above) >=
             kMajority * static_cast<double>(coarse.grid.PointsOf(c).size()) &&
         Height_m(column, up) > kMaxHeight_cells * edge_m;
}

bool MayLieFlat(const CoarseCloud& coarse, std::size_t c, const Vector3f& up) {
  static const float max_tilt_cos = static_cast<float>(std::cos(kMaxTilt_rad));
  const OrientedPoints& cells = coarse.cells;
  if (cells.normals[c].dot(up) >= max_tilt_cos) return false;  // the normal shows that it is level
  const Vector3f ray = cells.points[c] - cells.viewpoint.cast<float>();
  const float down_m = -ray.dot(up);
  if (down_m <= 0 || down_m >= kGrazing_sin * ray.norm()) return false;
  return Height_m(coarse.grid.moments(c), up) <= kMaxHeight_cells * coarse.grid.edge_m() &&
         !GoesOnAbove(coarse, c, up);
}

// The normal of the level plane through the cell and its neighbours at its height; zero if there is
// none.
Vector3f NormalOfPatch(const CoarseCloud& coarse, std::size_t c, const Vector3f& up) {
  const float sigma_m = coarse.cells.sigma_m[c];
  const Vector3f& middle = coarse.cells.points[c];
  Moments moments;
  coarse.grid.ForEachWithin(1, coarse.grid.cell(c), [&](std::size_t o) {
    if (std::abs(up.dot(coarse.cells.points[o] - middle)) > kGate_sigma * sigma_m) return;
    moments.Add(coarse.grid.moments(o), coarse.grid.Center(o) - middle);
  });
  Eigen::SelfAdjointEigenSolver<Matrix3f> axes;
  axes.computeDirect(moments.Covariance());
  const Vector3f normal = axes.eigenvectors().col(0);
  const float cosine = normal.dot(up);
  const bool is_level_plane = std::abs(cosine) >= static_cast<float>(std::cos(kMaxTilt_rad)) &&
                              axes.eigenvalues()(0) <= Square(kMaxThickness_sigma * sigma_m) &&
                              axes.eigenvalues()(1) >= Square(float{kGate_sigma} * sigma_m);
  if (!is_level_plane) return Vector3f::Zero();
  return cosine < 0 ? Vector3f(-normal) : normal;
}

}  // namespace

ReorientedCells ReorientLevelPatches(const Vector3f& up, CoarseCloud& coarse, const Work& work) {
  std::vector<Vector3f> normals(coarse.grid.size(), Vector3f::Zero());
  ParallelFor(normals.size(), ItemsPerChunk(800ns), work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      if (MayLieFlat(coarse, c, up)) normals[c] = NormalOfPatch(coarse, c, up);
    }
  });
  ReorientedCells turned;
  for (std::size_t c = 0; c < normals.size(); ++c) {
    if (normals[c].isZero()) continue;
    coarse.cells.normals[c] = normals[c];
    turned.push_back(static_cast<std::uint32_t>(c));
  }
  return turned;
}

void ReorientPointsOn(const std::vector<SupportPlane>& supports, const CoarseCloud& coarse,
                      const ReorientedCells& turned, OrientedPoints& points) {
  for (const SupportPlane& support : supports) {
    ReorientedCells of_support;
    std::ranges::set_intersection(support.cells, turned, std::back_inserter(of_support));
    const Vector3f normal = support.plane.normal.cast<float>();
    for (std::uint32_t c : of_support) {
      for (std::uint32_t i : coarse.grid.PointsOf(c)) {
        const double height_m = support.plane.Height_m(points.points[i]);
        if (std::abs(height_m) <= kGate_sigma * points.sigma_m[i]) {
          points.normals[i] = normal;
        }
      }
    }
  }
}

}  // namespace cwm::perception
