#include "perception/surface/surface_reconstruction.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "collision/geometry/triangle.h"
#include "perception/cloud/parallel_for.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/surface/projection_mesh.h"
#include "perception/surface/thinning.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

// chosen: the least ratio of a triangle's altitude to its longest edge; below it is a sliver. The
// front prefers angles of 10 degrees or more, with an altitude of at least sin 10 = 0.17 of an
// edge.
constexpr double kMinAltitude = 0.08;
// derived: cells with this edge have the tolerance as their diagonal: one small triangle explains
// all points of a cell.
constexpr double kIsolatedCell_m = kExplainedWithin_m / std::numbers::sqrt3;
// chosen: the least widening of the spacing while there are too many triangles; with less, there
// are more rounds for few more triangles.
constexpr double kMinWidening = 1.3;
// chosen: points that are thinned first; enough for the largest number of vertices.
constexpr std::size_t kSpacingSample = 65536;

double Tolerance_m(const OrientedPoints& points, std::size_t i) {
  return ExplainedWithin_m(i < points.sigma_m.size() ? points.sigma_m[i] : 0);
}

bool IsSliver(const Vector3& a, const Vector3& b, const Vector3& c) {
  const double longest_squared =
      std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  // Twice the area is altitude times edge.
  return (b - a).cross(c - a).norm() < kMinAltitude * longest_squared;
}

// Returns the triangles without slivers and repetitions, wound towards the viewpoint.
TriangleMesh Clean(const ProjectionMesh& front, const Vector3& viewpoint, const Work& work) {
  PollEvery poll(work, ItemsPerChunk(1us));
  TriangleMesh mesh;
  for (const Eigen::Vector3f& p : front.vertices) mesh.vertices.push_back(p.cast<double>());
  std::set<TriangleMesh::Triangle> known;
  for (TriangleMesh::Triangle triangle : front.triangles) {
    poll();
    TriangleMesh::Triangle key = triangle;
    std::sort(key.begin(), key.end());
    const Vector3& a = mesh.vertices[triangle[0]];
    const Vector3& b = mesh.vertices[triangle[1]];
    const Vector3& c = mesh.vertices[triangle[2]];
    if (IsSliver(a, b, c) || !known.insert(key).second) continue;
    if ((b - a).cross(c - a).dot(viewpoint - a) < 0) std::swap(triangle[1], triangle[2]);
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

// Per vertex, the triangles that meet there.
std::vector<std::vector<std::uint32_t>> Fans(const TriangleMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> fans(mesh.vertices.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t vertex : mesh.triangles[i]) fans[vertex].push_back(i);
  }
  return fans;
}

// A mesh with data for repeated queries.
struct SearchedMesh {
  using Fan = std::vector<std::uint32_t>;

  SearchedMesh(const TriangleMesh& of, const ThinnedPoints& points)
      : mesh(of), thinned(points), fans(Fans(of)) {
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vector3 edge = mesh.vertices[b] - mesh.vertices[a];
      normals.push_back(edge.cross(mesh.vertices[c] - mesh.vertices[a]).normalized());
    }
  }

  const Fan& FanOf(std::size_t cell) const { return fans[thinned.vertex_of_cell[cell]]; }
  bool AnyNear(const Fan& fan, const Vector3& p, double tolerance_m) const {
    return std::any_of(fan.begin(), fan.end(), [&](std::uint32_t i) {
      const auto& [a, b, c] = mesh.triangles[i];
      // The distance from the plane is a cheap lower bound.
      if (std::abs(normals[i].dot(p - mesh.vertices[a])) > tolerance_m) return false;
      const Vector3 nearest =
          NearestOnTriangle(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c], p);
      return (nearest - p).norm() <= tolerance_m;
    });
  }

  const TriangleMesh& mesh;
  const ThinnedPoints& thinned;
  std::vector<Fan> fans;         // per vertex
  std::vector<Vector3> normals;  // unit, of the triangles
};

// Tests whether points of a cell lie near the mesh: near the triangles around the cell's own vertex
// or, tested next, around those of the neighbouring cells. Nearer triangles do not exist elsewhere.
class CellSearch {
 public:
  CellSearch(const SearchedMesh& mesh, std::size_t cell)
      : mesh_(mesh), cell_(cell), own_(mesh.FanOf(cell)) {}

  bool Explains(const Vector3& p, double tolerance_m) {
    if (mesh_.AnyNear(own_, p, tolerance_m)) return true;
    if (!around_) around_ = FansAround();
    return mesh_.AnyNear(*around_, p, tolerance_m);
  }

 private:
  // Contains each triangle once, for all points of the cell.
  SearchedMesh::Fan FansAround() const {
    SearchedMesh::Fan around;
    const VoxelGrid& grid = mesh_.thinned.grid;
    grid.ForEachWithin(1, grid.cell(cell_), [&](std::size_t other) {
      const SearchedMesh::Fan& fan = mesh_.FanOf(other);
      around.insert(around.end(), fan.begin(), fan.end());
    });
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    return around;
  }

  const SearchedMesh& mesh_;
  const std::size_t cell_;
  const SearchedMesh::Fan& own_;
  std::optional<SearchedMesh::Fan> around_;
};

// An equilateral triangle around `center` that faces the viewpoint.
std::array<Vector3, 3> SmallTriangle(const Vector3& center, double radius_m,
                                     const Vector3& viewpoint) {
  const Vector3 towards = viewpoint - center;
  const Matrix3 basis =
      BasisFromZ(towards.norm() > 0 ? Vector3(towards.normalized()) : Vector3::UnitZ());
  std::array<Vector3, 3> corners;
  for (int i = 0; i < 3; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / 3;
    corners[i] = center + radius_m * (std::cos(angle_rad) * basis.col(0) +
                                      std::sin(angle_rad) * basis.col(1));
  }
  return corners;
}

struct Cover {
  const OrientedPoints& points;
  double spacing_m = 0;
};

// Covers points that are near no triangle by small triangles, one per cell.
void CoverIsolated(const Cover& cover, const std::vector<std::uint32_t>& lonely, Surface& surface) {
  std::vector<Eigen::Vector3f> positions;
  for (const std::uint32_t i : lonely) positions.push_back(cover.points.points[i]);
  if (positions.empty()) return;
  const double edge_m = std::max(kIsolatedCell_m, cover.spacing_m);
  const VoxelGrid grid = VoxelGrid::Build(positions, static_cast<float>(edge_m));
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const auto corners = SmallTriangle(grid.Centroid(cell).cast<double>(), 0.5 * cover.spacing_m,
                                       cover.points.viewpoint);
    const auto first = static_cast<std::uint32_t>(surface.mesh.vertices.size());
    surface.mesh.vertices.insert(surface.mesh.vertices.end(), corners.begin(), corners.end());
    surface.mesh.triangles.push_back({first, first + 1, first + 2});
    for (const std::uint32_t member : grid.PointsOf(cell)) {
      const Vector3 p = positions[member].cast<double>();
      const double distance_m =
          (NearestOnTriangle(corners[0], corners[1], corners[2], p) - p).norm();
      if (distance_m <= Tolerance_m(cover.points, lonely[member])) {
        surface.explained.push_back(lonely[member]);
      }
    }
  }
}

void DropUnusedVertices(TriangleMesh& mesh) {
  constexpr std::uint32_t kUnused = ~0U;
  std::vector<std::uint32_t> renamed(mesh.vertices.size(), kUnused);
  std::vector<Vector3> used;
  for (TriangleMesh::Triangle& triangle : mesh.triangles) {
    for (std::uint32_t& vertex : triangle) {
      if (renamed[vertex] == kUnused) {
        renamed[vertex] = static_cast<std::uint32_t>(used.size());
        used.push_back(mesh.vertices[vertex]);
      }
      vertex = renamed[vertex];
    }
  }
  mesh.vertices = std::move(used);
}

// Per point, whether it is near the mesh. Empty as soon as the other points fill more than
// `max_isolated_cells` cells, each of which needs a small triangle.
std::optional<std::vector<char>> NearPoints(const OrientedPoints& points,
                                            const ThinnedPoints& thinned, const TriangleMesh& mesh,
                                            std::size_t max_isolated_cells, const Work& work) {
  const SearchedMesh searched(mesh, thinned);
  std::vector<char> near(points.size(), 0);
  std::atomic<std::size_t> isolated_cells = 0;
  ParallelFor(
      thinned.grid.size(), ItemsPerChunk(25us), work, [&](std::size_t begin, std::size_t end) {
        PollEvery poll(work, ItemsPerChunk(1us));
        for (std::size_t cell = begin; cell < end && isolated_cells <= max_isolated_cells; ++cell) {
          CellSearch search(searched, cell);
          bool lonely = false;
          for (const std::uint32_t i : thinned.grid.PointsOf(cell)) {
            poll();
            near[i] = search.Explains(points.points[i].cast<double>(), Tolerance_m(points, i));
            lonely = lonely || !near[i];
          }
          if (lonely) ++isolated_cells;
        }
      });
  if (isolated_cells > max_isolated_cells) return std::nullopt;
  return near;
}

// The mesh with small triangles for points that are near none of its own; empty if there would be
// more than `max_triangles` in total.
std::optional<Surface> Complete(const OrientedPoints& points, const ThinnedPoints& thinned,
                                TriangleMesh mesh, std::size_t max_triangles, const Work& work) {
  // Cells of small triangles have the size of these cells, or more if these are smaller.
  const bool counts = thinned.grid.edge_m() >= kIsolatedCell_m;
  const auto near =
      NearPoints(points, thinned, mesh,
                 counts ? max_triangles - std::min(max_triangles, mesh.triangles.size())
                        : std::numeric_limits<std::size_t>::max(),
                 work);
  if (!near) return std::nullopt;
  Surface surface{.mesh = std::move(mesh), .explained = {}};
  std::vector<std::uint32_t> lonely;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    ((*near)[i] ? surface.explained : lonely).push_back(i);
  }
  CoverIsolated({.points = points, .spacing_m = thinned.grid.edge_m()}, lonely, surface);
  std::sort(surface.explained.begin(), surface.explained.end());
  DropUnusedVertices(surface.mesh);
  return surface;
}

// The factor that reduces `count` vertices or triangles approximately to `max_triangles`: their
// number falls with the square of the spacing on a surface, and with its cube in points that fill
// space.
double Widening(std::size_t count, std::size_t max_triangles) {
  return std::max(kMinWidening,
                  std::cbrt(static_cast<double>(count) / static_cast<double>(max_triangles)));
}

// The number of triangles from which the exact number has no effect on the widening.
std::size_t TooManyTriangles(std::size_t max_triangles) {
  return static_cast<std::size_t>(std::pow(kMinWidening, 3) * static_cast<double>(max_triangles)) +
         1;
}

// The spacing, widened until a sample does not have too many vertices: all points have hardly
// fewer. Thinning all points repeatedly took a sixth of the time for the shapes of a million points
// of noisy bumps.
double WidenedForSample(double spacing_m, const OrientedPoints& points, std::size_t max_triangles,
                        const Work& work) {
  const std::size_t step = points.size() / kSpacingSample;
  if (step < 2) return spacing_m;
  std::vector<Eigen::Vector3f> sample;
  for (std::size_t i = 0; i < points.size(); i += step) sample.push_back(points.points[i]);
  while (true) {
    const ThinnedPoints thinned = Thin(sample, static_cast<float>(spacing_m), work);
    const std::size_t count = 2 * thinned.vertices.size();
    if (count <= max_triangles) return spacing_m;
    spacing_m = Widening(count, max_triangles) * thinned.grid.edge_m();
  }
}

}  // namespace

Surface ReconstructSurface(const OrientedPoints& points, const SurfaceOptions& options,
                           const Work& work) {
  if (points.points.empty()) return {};
  const std::size_t max_triangles = std::max(options.max_triangles, 1);
  const std::size_t tried = std::max<std::size_t>(max_triangles, 2);  // one vertex is always tried
  // With vertices closer than the noise, the mesh would follow the noise.
  const double noise_m = Median(points.sigma_m);
  double spacing_m =
      WidenedForSample(std::max({kSubNoise_m, options.spacing_m, noise_m}), points, tried, work);
  while (true) {
    const ThinnedPoints thinned = Thin(points.points, static_cast<float>(spacing_m), work);
    // A surface has about two triangles per vertex, so it is not triangulated before there are few
    // enough vertices.
    work.Poll();
    std::size_t count = 2 * thinned.vertices.size();
    if (count <= tried) {
      const ProjectionMesh front = MeshByProjection(thinned.vertices, thinned.grid.edge_m(), work);
      std::optional<Surface> surface =
          Complete(points, thinned, Clean(front, points.viewpoint, work),
                   TooManyTriangles(max_triangles), work);
      count = surface ? surface->mesh.triangles.size() : TooManyTriangles(max_triangles);
      if (surface && count <= max_triangles) return *std::move(surface);
    }
    spacing_m = Widening(count, max_triangles) * thinned.grid.edge_m();
  }
}

}  // namespace cwm::perception
