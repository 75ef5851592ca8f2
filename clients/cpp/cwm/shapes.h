// Shapes: objects are made of them, and queries are asked with them. Each lies in its own frame S.
// Lengths are metres.
#pragma once

#include <Eigen/Geometry>
#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "cwm/namespace.h"

namespace cwm::CWM_API {

// Centred at the origin.
struct Sphere {
  double radius_m = 0;
};

// Centred at the origin, edges along the axes.
struct Box {
  double size_x_m = 0;
  double size_y_m = 0;
  double size_z_m = 0;
};

// Centred at the origin, axis z.
struct Cylinder {
  double radius_m = 0;
  double length_m = 0;
};

// All points within the radius of a centred segment on z. The length is the distance between the
// centres of the two end spheres.
struct Capsule {
  double radius_m = 0;
  double length_m = 0;
};

// Axis z, centred: the bottom disc at z = -length/2, the top disc at z = +length/2. One radius may
// be 0.
struct Cone {
  double radius_bottom_m = 0;
  double radius_top_m = 0;
  double length_m = 0;
};

// Solid where z <= 0.
struct HalfSpace {};

// Corners x, y in columns.
using Polygon = Eigen::Matrix2Xd;

// Solid for -thickness <= z <= 0 inside the outline and outside the holes.
struct Plate {
  Polygon outline = {};
  double thickness_m = 0;
  std::vector<Polygon> holes = {};
};

// Three vertices in each column.
using Triangles = Eigen::Matrix<std::uint32_t, 3, Eigen::Dynamic>;

// Triangles: solid if they are watertight, else a surface. They need not share vertices. Give the
// vertices and triangles, or the hash of a mesh that the server has; objects of a world have the
// hash alone, of which WorldView::ReadMesh reads the triangles.
struct Mesh {
  Eigen::Matrix3Xd vertices = {};
  Triangles triangles = {};
  std::string hash = {};
};

// The convex hull of a mesh's vertices.
struct Convex : Mesh {};

using Shape = std::variant<Sphere, Box, Cylinder, Capsule, Cone, HalfSpace, Plate, Mesh, Convex>;

// A shape in the frame of a body.
struct Placed {
  Shape shape = {};
  Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();
};

// One shape or several that move together.
class Body {
 public:
  template <class T>
  requires(std::constructible_from<Shape, T> && !std::same_as<T, Body>) Body(T shape)
      : parts_{Placed{Shape(std::move(shape))}} {}               // NOLINT: implicit
  Body(Placed part) : parts_{std::move(part)} {}                 // NOLINT: implicit
  Body(std::vector<Placed> parts) : parts_(std::move(parts)) {}  // NOLINT: implicit
  Body(std::initializer_list<Placed> parts) : parts_(parts) {}

  const std::vector<Placed>& parts() const { return parts_; }

 private:
  std::vector<Placed> parts_;
};

}  // namespace cwm::CWM_API
