// The surfaces of rigid bodies that a robot moves, prepared for images of them and for distances of
// measured points.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/hybrid_model.h"
#include "collision/kernels/triangle_tree.h"

namespace cwm::perception {

// The signed distance of a rigid body's surface at the centres of cells. Distances change by no
// more than a point moves, so a value bounds those in its whole cell.
struct DistanceGrid {
  Eigen::Vector3f origin_L = Eigen::Vector3f::Zero();  // the least corner of the first cell
  float cell_m = 0;
  float cells_per_m = 0;
  std::array<int, 3> size = {};        // cells along x, y, z; x is the fastest
  std::vector<float> distance_m = {};  // negative inside

  // Bounds of the distance at p; NaN outside of the grid.
  struct Bounds {
    float least_m = std::numeric_limits<float>::quiet_NaN();
    float greatest_m = std::numeric_limits<float>::quiet_NaN();
  };
  Bounds At(const Eigen::Vector3f& p_L) const {
    const Eigen::Vector3f cell = cells_per_m * (p_L - origin_L);
    if (!(cell.x() >= 0 && cell.y() >= 0 && cell.z() >= 0 &&
          cell.x() < static_cast<float>(size[0]) && cell.y() < static_cast<float>(size[1]) &&
          cell.z() < static_cast<float>(size[2]))) {
      return {};
    }
    const Eigen::Array3i index = cell.cast<int>();
    const std::size_t row = static_cast<std::size_t>(index.z()) * size[1] + index.y();
    const float at_center_m = distance_m[row * size[0] + index.x()];
    // A little more than the distance from the centre, for rounding.
    const float shift_m =
        1.001F * cell_m *
        (cell - index.matrix().cast<float>() - Eigen::Vector3f::Constant(0.5F)).norm();
    return {at_center_m - shift_m, at_center_m + shift_m};
  }
};

// The surface of one rigid body in its own frame L. Immutable. Distances are exact, of shapes by
// their formulas and of meshes and hulls over their triangles; images show round shapes within half
// a millimetre. Half-spaces are left out, since no image bounds them.
class LinkSurface {
 public:
  // `max_cells` limits the memory, 4 bytes a cell, and the time of preparation, about 1 us a cell.
  static constexpr int kMaxLinkCells = 8192;
  explicit LinkSurface(std::span<const Placed<>> parts, int max_cells = kMaxLinkCells);

  // True for a body without triangles. It has no bounds, and no point is near it.
  bool empty() const { return triangles_.empty(); }
  const Aabb& bounds_L() const { return bounds_L_; }

  // For images. Triangles that are not two-sided wind counter-clockwise seen from outside.
  struct Triangle {
    std::array<std::uint32_t, 3> corners;
    bool two_sided = false;
  };
  const std::vector<Eigen::Vector3f>& vertices_L() const { return vertices_L_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }

  // Bounds of the signed distance, some nanoseconds; NaN farther away than any margin of the grid.
  DistanceGrid::Bounds BoundsAt(const Eigen::Vector3f& p_L) const { return grid_.At(p_L); }
  // A point is within a margin (not negative) if it is in a solid or at most that far from the
  // surface. Quick() tells what such bounds say, which may leave it open; IsWithin() decides.
  enum class Proximity : std::uint8_t { kWithin, kBeyond, kOpen };
  static Proximity Quick(const DistanceGrid::Bounds& bounds, float margin_m) {
    if (bounds.greatest_m <= margin_m) return Proximity::kWithin;
    if (bounds.least_m > margin_m) return Proximity::kBeyond;
    return std::isnan(bounds.least_m) && margin_m <= kGridReach_m ? Proximity::kBeyond
                                                                  : Proximity::kOpen;
  }
  bool IsWithin(const Eigen::Vector3f& p_L, float margin_m) const;
  // False only if no point of the ball is within the margin. Fast.
  bool MayBeWithin(const Eigen::Vector3f& center_L, float radius_m, float margin_m) const;
  // The distance from the solid, 0 inside; infinite if it is more than `max_distance_m`.
  double Distance_m(const Eigen::Vector3f& p_L, double max_distance_m) const;

 private:
  // chosen: the grid reaches this far beyond the surface, more than margins of slow robots; points
  // beyond cost a search in the tree if a margin is larger.
  static constexpr double kGridReach_m = 0.06;
  struct Part {
    Pose X_GL = Pose::Identity();
    Shape shape;
    std::optional<collision::TriangleTree> tree;  // of a mesh or hull, in the frame L; else empty
    bool is_solid = true;
  };
  struct Nearest {
    double distance_m = std::numeric_limits<double>::infinity();
    Vector3 point_L = Vector3::Zero();
  };
  void AddTriangles(const TriangleMesh& mesh_L, bool is_solid);
  void FillGrid(int max_cells);
  bool IsInside(const Vector3& p_L) const;
  // The nearest point of any part's surface; infinitely far if none is nearer than the limit.
  Nearest NearestPoint(const Vector3& p_L, double max_distance_m) const;

  std::vector<Part> parts_;
  std::vector<Eigen::Vector3f> vertices_L_;
  std::vector<Triangle> triangles_;
  Aabb bounds_L_;
  DistanceGrid grid_;  // around bounds_L_ and kGridReach_m more
};

// The surface of an object's model, in the object's frame: all its shapes, surfaces and handles.
LinkSurface SurfaceOf(const HybridModel& model);

// A collision geometry of a robot's link.
struct LinkGeometry {
  int link = 0;                  // index into the links of the robot
  Pose X_LG = Pose::Identity();  // the shape in the link's frame
  const Shape* shape = nullptr;  // not null
};

// The links of a robot. Immutable; made once for a robot's model. It knows collision geometry only:
// a margin about it must also cover how far the visible surface stands out from it.
class RobotSurface {
 public:
  // One surface per link, empty for links without geometry.
  RobotSurface(std::span<const LinkGeometry> geometries, int link_count);

  const std::vector<LinkSurface>& links() const { return links_; }

 private:
  std::vector<LinkSurface> links_;
};

}  // namespace cwm::perception
