#include "perception/live/robot_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "collision/geometry/triangle.h"

namespace cwm::perception {
namespace {

// chosen: smaller cells hardly leave fewer points undecided, since margins are 20 mm and more.
constexpr double kMinCell_m = 0.008;
// chosen: an object that is carried is prepared between two frames.
constexpr int kMaxCarriedCells = 4096;

int CellsAlong(double length_m, double cell_m) {
  return std::max(1, static_cast<int>(std::ceil(length_m / cell_m)));
}

DistanceGrid GridAround(const Aabb& bounds_L, int max_cells) {
  const Vector3& least = bounds_L.min();
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
  for (const Placed<>& placed : parts) {
    if (std::holds_alternative<HalfSpace>(placed.shape)) continue;
    TriangleMesh mesh_L = Tessellate(placed.shape);
    if (mesh_L.triangles.empty()) continue;
    for (Vector3& p : mesh_L.vertices) p = placed.X_FS * p;
    const Mesh* mesh = std::get_if<Mesh>(&placed.shape);
    const bool is_hull = std::holds_alternative<Convex>(placed.shape);
    Part& part = parts_.emplace_back();
    part.X_GL = placed.X_FS.inverse();
    part.shape = placed.shape;
    part.is_solid = mesh == nullptr || mesh->watertight;
    if (mesh != nullptr || is_hull) part.tree.emplace(mesh_L);
    AddTriangles(mesh_L, part.is_solid);
    bounds_L_.extend(TightBounds(placed.shape, placed.X_FS));
  }
  if (!empty()) FillGrid(max_cells);
}

void LinkSurface::AddTriangles(const TriangleMesh& mesh_L, bool is_solid) {
  const bool is_inward = is_solid && SignedVolume_m3(mesh_L) < 0;
  const auto first = static_cast<std::uint32_t>(vertices_L_.size());
  for (const Vector3& p : mesh_L.vertices) vertices_L_.push_back(p.cast<float>());
  for (auto [a, b, c] : mesh_L.triangles) {
    if (is_inward) std::swap(b, c);
    triangles_.push_back({.corners = {first + a, first + b, first + c}, .two_sided = !is_solid});
  }
}

void LinkSurface::FillGrid(int max_cells) {
  const Vector3 reach_m = Vector3::Constant(kGridReach_m);
  grid_ = GridAround({bounds_L_.min() - reach_m, bounds_L_.max() + reach_m}, max_cells);
  grid_.distance_m.reserve(static_cast<std::size_t>(grid_.size[0]) * grid_.size[1] * grid_.size[2]);
  // The nearest point of the cell before bounds the distance of a cell; and no surface lies between
  // the two if that cell is farther from the surface than from this one.
  Nearest before;
  Vector3 p_before = Vector3::Zero();
  bool is_inside = false;
  for (int z = 0; z < grid_.size[2]; ++z) {
    for (int y = 0; y < grid_.size[1]; ++y) {
      for (int x = 0; x < grid_.size[0]; ++x) {
        const Vector3 p =
            grid_.origin_L.cast<double>() + grid_.cell_m * Vector3(x + 0.5, y + 0.5, z + 0.5);
        const bool is_first = grid_.distance_m.empty();
        const bool may_cross = is_first || before.distance_m <= 1.001 * (p - p_before).norm();
        if (may_cross) is_inside = IsInside(p);
        const double limit_m = 1.001 * (p - before.point_L).norm() + 1e-9;
        before = NearestPoint(p, is_first ? std::numeric_limits<double>::infinity() : limit_m);
        p_before = p;
        grid_.distance_m.push_back(
            static_cast<float>(is_inside ? -before.distance_m : before.distance_m));
      }
    }
  }
}

bool LinkSurface::IsInside(const Vector3& p_L) const {
  return std::any_of(parts_.begin(), parts_.end(), [&](const Part& part) {
    if (!part.tree) return SignedDistance_m(part.shape, part.X_GL * p_L) < 0;
    return part.is_solid && part.tree->bounds().contains(p_L) && part.tree->Contains(p_L);
  });
}

LinkSurface::Nearest LinkSurface::NearestPoint(const Vector3& p_L, double max_distance_m) const {
  Nearest nearest{.distance_m = max_distance_m};
  bool found = false;
  for (const Part& part : parts_) {
    Nearest of_part;
    if (part.tree) {
      const auto on_mesh = part.tree->NearestPoint(p_L, nearest.distance_m);
      of_part = {on_mesh.distance_m, on_mesh.point};
    } else {
      const SurfacePoint point_G = NearestSurfacePoint(part.shape, part.X_GL * p_L);
      of_part = {std::abs(point_G.signed_distance_m),
                 part.X_GL.inverse(Eigen::Isometry) * point_G.nearest};
    }
    if (!(of_part.distance_m < nearest.distance_m)) continue;
    nearest = of_part;
    found = true;
  }
  return found ? nearest : Nearest{};
}

bool LinkSurface::IsWithin(const Eigen::Vector3f& p_L, float margin_m) const {
  const Proximity quick = Quick(BoundsAt(p_L), margin_m);
  if (quick != Proximity::kOpen) return quick == Proximity::kWithin;
  const Vector3 p = p_L.cast<double>();
  const auto is_near = [&](const Part& part) {
    if (!part.tree) return SignedDistance_m(part.shape, part.X_GL * p) <= margin_m;
    bool found = false;  // any triangle within the margin ends the search
    const auto visit = [&](const collision::TriangleCorners& triangle, std::int32_t) {
      const auto& [a, b, c] = triangle.corners;
      found = (NearestOnTriangle(a, b, c, p) - p).norm() <= margin_m;
      return found ? collision::TriangleTree::kEnd : margin_m;
    };
    part.tree->ForEachNear(Aabb(p, p), margin_m, visit);
    return found;
  };
  return std::any_of(parts_.begin(), parts_.end(), is_near) || IsInside(p);
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
  return IsInside(p) ? 0 : NearestPoint(p, limit_m).distance_m;
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
