// The surfaces of rigid bodies that a robot moves, prepared for images of them and for distances of
// measured points.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
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
  std::array<int, 3> size = {};                        // cells along x, y, z; x is the fastest
  std::vector<float> distance_m = {};                  // negative inside
  float radius_m() const { return 0.8661F * cell_m; }  // centre to corner, rounded up

  // The value of the cell that holds p; NaN outside of the grid.
  float At(const Eigen::Vector3f& p_L) const;
};

// The surface of one rigid body in its own frame L. Immutable. Round shapes are approximated within
// deviation_m() by triangles; meshes are taken as they are. Half-spaces are left out, since no
// image bounds them.
class LinkSurface {
 public:
  // `max_cells` limits the memory, 4 bytes a cell, and the time of preparation, about 1 us a cell.
  static constexpr int kMaxLinkCells = 32768;
  explicit LinkSurface(std::span<const Placed<>> parts, int max_cells = kMaxLinkCells);

  // True for a body without triangles. It has no bounds, and no point is near it.
  bool empty() const { return triangles_.empty(); }
  const Aabb& bounds_L() const { return bounds_L_; }
  double deviation_m() const { return deviation_m_; }

  // For images. Triangles that are not two-sided wind counter-clockwise seen from outside.
  struct Triangle {
    std::array<std::uint32_t, 3> corners;
    bool two_sided = false;
  };
  const std::vector<Eigen::Vector3f>& vertices_L() const { return vertices_L_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }

  // True if p is in a solid, or at most `margin_m` (not negative) from the surface.
  bool IsWithin(const Eigen::Vector3f& p_L, float margin_m) const;
  // False only if no point of the ball is within the margin. Fast.
  bool MayBeWithin(const Eigen::Vector3f& center_L, float radius_m, float margin_m) const;
  // The distance from the solid, 0 inside; infinite if it is more than `max_distance_m`.
  double Distance_m(const Eigen::Vector3f& p_L, double max_distance_m) const;

 private:
  struct Part {
    collision::TriangleTree tree;
    bool is_solid = false;
  };
  void Add(const TriangleMesh& mesh, const Pose& X_LS, bool is_solid);
  void FillGrid(int max_cells);
  bool IsInside(const Vector3& p_L) const;
  double SurfaceDistance_m(const Vector3& p_L, double max_distance_m) const;

  std::vector<Part> parts_;
  std::vector<Eigen::Vector3f> vertices_L_;
  std::vector<Triangle> triangles_;
  Aabb bounds_L_;
  double deviation_m_ = 0;
  DistanceGrid grid_;
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
