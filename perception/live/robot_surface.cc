#include "perception/live/robot_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/geometry/tessellate.h"

namespace cwm::perception {
namespace {

// chosen: smaller cells hardly leave fewer points undecided, since margins are 20 mm and more.
constexpr double kMinCell_m = 0.004;
// chosen: an object that is carried is prepared between two frames.
constexpr int kMaxCarriedCells = 4096;

int CellsAlong(double length_m, double cell_m) {
  return std::max(1, static_cast<int>(std::ceil(length_m / cell_m)));
}

DistanceGrid GridAround(const Aabb& bounds_L, int max_cells) {
  const Vector3 least = bounds_L.min();
  const Vector3 size_m = bounds_L.sizes();
  double cell_m = std::max(kMinCell_m, std::cbrt(size_m.prod() / max_cells));
  const auto cells = [&] {
    return static_cast<double>(CellsAlong(size_m.x(), cell_m)) * CellsAlong(size_m.y(), cell_m) *
           CellsAlong(size_m.z(), cell_m);
  };
  while (cells() > max_cells) cell_m *= 1.05;  // counts are rounded up
  DistanceGrid grid;
  grid.origin_L = least.cast<float>();
  grid.cell_m = static_cast<float>(cell_m);
  grid.cells_per_m = 1 / grid.cell_m;
  for (int axis = 0; axis < 3; ++axis) {
    grid.size[static_cast<std::size_t>(axis)] = CellsAlong(size_m[axis], cell_m);
  }
  return grid;
}

}  // namespace

LinkSurface::LinkSurface(std::span<const Placed<>> parts, int max_cells) {
  for (const Placed<>& part : parts) {
    if (std::holds_alternative<HalfSpace>(part.shape)) continue;
    const Mesh* mesh = std::get_if<Mesh>(&part.shape);
    Add(Tessellate(part.shape), part.X_FS, mesh == nullptr || mesh->watertight);
    deviation_m_ = std::max(deviation_m_, DeviationBound_m(part.shape));
  }
  if (!empty()) FillGrid(max_cells);
}

void LinkSurface::Add(const TriangleMesh& mesh, const Pose& X_LS, bool is_solid) {
  if (mesh.triangles.empty()) return;
  TriangleMesh placed = mesh;
  for (Vector3& p : placed.vertices) p = X_LS * p;
  const bool is_inward = is_solid && SignedVolume_m3(placed) < 0;
  const auto first = static_cast<std::uint32_t>(vertices_L_.size());
  for (const Vector3& p : placed.vertices) vertices_L_.push_back(p.cast<float>());
  for (auto [a, b, c] : placed.triangles) {
    if (is_inward) std::swap(b, c);
    triangles_.push_back({.corners = {first + a, first + b, first + c}, .two_sided = !is_solid});
    bounds_L_.extend(placed.vertices[a]).extend(placed.vertices[b]).extend(placed.vertices[c]);
  }
  parts_.push_back({.tree = collision::TriangleTree(placed), .is_solid = is_solid});
}

void LinkSurface::FillGrid(int max_cells) {
  const Vector3 reach_m = Vector3::Constant(kGridReach_m);
  grid_ = GridAround({bounds_L_.min() - reach_m, bounds_L_.max() + reach_m}, max_cells);
  grid_.distance_m.reserve(static_cast<std::size_t>(grid_.size[0]) * grid_.size[1] * grid_.size[2]);
  // A cell is one step from the cell before it, which bounds its distance; and no surface lies
  // between them if that cell is farther from the surface than the step.
  double before_m = std::numeric_limits<double>::infinity();
  bool is_inside = false;
  Vector3 p_before = Vector3::Zero();
  for (int z = 0; z < grid_.size[2]; ++z) {
    for (int y = 0; y < grid_.size[1]; ++y) {
      for (int x = 0; x < grid_.size[0]; ++x) {
        const Vector3 p =
            grid_.origin_L.cast<double>() + grid_.cell_m * Vector3(x + 0.5, y + 0.5, z + 0.5);
        const double step_m = (p - p_before).norm();
        const double distance_m = SurfaceDistance_m(p, before_m + 1.001 * step_m);
        if (!(before_m > step_m) || std::isinf(before_m)) is_inside = IsInside(p);
        grid_.distance_m.push_back(static_cast<float>(is_inside ? -distance_m : distance_m));
        before_m = distance_m;
        p_before = p;
      }
    }
  }
}

bool LinkSurface::IsInside(const Vector3& p_L) const {
  return std::any_of(parts_.begin(), parts_.end(), [&](const Part& part) {
    return part.is_solid && part.tree.bounds().contains(p_L) && part.tree.Contains(p_L);
  });
}

double LinkSurface::SurfaceDistance_m(const Vector3& p_L, double max_distance_m) const {
  double distance_m = std::numeric_limits<double>::infinity();
  for (const Part& part : parts_) {
    const double limit_m = std::min(max_distance_m, distance_m);
    distance_m = std::min(distance_m, part.tree.NearestPoint(p_L, limit_m).distance_m);
  }
  return distance_m;
}

bool LinkSurface::IsWithin(const Eigen::Vector3f& p_L, float margin_m) const {
  const Proximity quick = Quick(BoundsAt(p_L), margin_m);
  if (quick != Proximity::kOpen) return quick == Proximity::kWithin;
  return !empty() && std::isfinite(Distance_m(p_L, margin_m));
}

bool LinkSurface::MayBeWithin(const Eigen::Vector3f& center_L, float radius_m,
                              float margin_m) const {
  const float reach_m = radius_m + margin_m;
  const DistanceGrid::Bounds bounds = grid_.At(center_L);
  if (!std::isnan(bounds.least_m)) return bounds.least_m <= reach_m;
  if (empty()) return false;
  return bounds_L_.squaredExteriorDistance(center_L.cast<double>()) <=
         static_cast<double>(reach_m) * reach_m;
}

double LinkSurface::Distance_m(const Eigen::Vector3f& p_L, double max_distance_m) const {
  const Vector3 p = p_L.cast<double>();
  // The tree finds only what is nearer than its limit.
  const double limit_m = std::nextafter(max_distance_m, std::numeric_limits<double>::infinity());
  if (bounds_L_.exteriorDistance(p) > max_distance_m) {
    return std::numeric_limits<double>::infinity();
  }
  return IsInside(p) ? 0 : SurfaceDistance_m(p, limit_m);
}

LinkSurface SurfaceOf(const HybridModel& model) {
  std::vector<Placed<>> parts;
  for (const ShapePart& part : model.shapes) parts.push_back({part.X_OS, part.shape});
  const auto add = [&](const Mesh& mesh) {
    if (mesh.mesh != nullptr) parts.push_back({Pose::Identity(), mesh});
  };
  for (const SurfacePart& part : model.surfaces) add(part.surface);
  for (const Handle& handle : model.handles) add(handle.surface);
  return LinkSurface(parts, kMaxCarriedCells);
}

RobotSurface::RobotSurface(std::span<const LinkGeometry> geometries, int link_count) {
  std::vector<std::vector<Placed<>>> parts(static_cast<std::size_t>(link_count));
  for (const LinkGeometry& geometry : geometries) {
    parts[static_cast<std::size_t>(geometry.link)].push_back({geometry.X_LG, *geometry.shape});
  }
  for (const std::vector<Placed<>>& of_link : parts) links_.emplace_back(of_link);
}

}  // namespace cwm::perception
