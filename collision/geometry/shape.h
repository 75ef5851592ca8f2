// The closed set of shapes that the world is made of. A shape holds only its dimensions, in a
// canonical frame; a pose beside it (`Placed`) says where it is. The set is closed on purpose: a
// new shape breaks the build everywhere that must handle it.
#pragma once

#include <array>
#include <memory>
#include <string_view>
#include <variant>
#include <vector>

#include "collision/geometry/polygon.h"
#include "collision/geometry/pose.h"
#include "collision/geometry/triangle_mesh.h"

namespace cwm {

// Centred at the origin.
struct Sphere {
  double radius_m = 0;
  friend bool operator==(const Sphere&, const Sphere&) = default;
};

// Centred at the origin, edges along the axes.
struct Box {
  Vector3 size_m = Vector3::Zero();
  friend bool operator==(const Box&, const Box&) = default;
};

// Centred at the origin, axis z.
struct Cylinder {
  double radius_m = 0;
  double length_m = 0;
  friend bool operator==(const Cylinder&, const Cylinder&) = default;
};

// Axis z, centred: the bottom disc lies at z = -length/2, the top disc at z = +length/2. A cup is a
// truncated cone; a top radius of 0 is an apex. At least one radius is positive; the top may be the
// wider one.
struct Cone {
  double radius_bottom_m = 0;
  double radius_top_m = 0;
  double length_m = 0;
  friend bool operator==(const Cone&, const Cone&) = default;
};

// All points within `radius_m` of the segment on z from -length/2 to +length/2.
struct Capsule {
  double radius_m = 0;
  double length_m = 0;  // between the two centres
  friend bool operator==(const Capsule&, const Capsule&) = default;
};

// All points with z <= 0.
struct HalfSpace {
  friend bool operator==(const HalfSpace&, const HalfSpace&) = default;
};

// A slab with a polygonal outline and holes in the xy plane: solid for -thickness <= z <= 0. The
// top face of a support is z = 0.
struct Plate {
  Polygon outline;
  std::vector<Polygon> holes;
  double thickness_m = 0;
  friend bool operator==(const Plate&, const Plate&) = default;
};

// A convex polyhedron, as its watertight outward-wound hull. Shared and immutable.
struct Convex {
  std::shared_ptr<const TriangleMesh> hull;
  friend bool operator==(const Convex& a, const Convex& b);
};

// A hole of a mesh that triangles of no file close. The true surface there is unknown, but it is
// taken to lie within the convex hull of the hole's boundary, and so within the capsule here.
struct MeshCap {
  std::array<Vector3, 2> axis = {Vector3::Zero(), Vector3::Zero()};  // the ends of the capsule's
  double radius_m = 0;
  double diameter_m = 0;  // the largest distance of two vertices of the boundary
  // derived: every plane across the axis that meets the hull also meets the boundary, so that no
  // point of the hull is farther from the boundary than the capsule is thick.
  double bound_m() const { return 2 * radius_m; }
  friend bool operator==(const MeshCap&, const MeshCap&) = default;
};

// nullptr: no hole was closed. Shared and immutable.
using MeshCaps = std::shared_ptr<const std::vector<MeshCap>>;

// An arbitrary mesh: solid if watertight, otherwise a surface without an inside. Shared and
// immutable.
struct Mesh {
  std::shared_ptr<const TriangleMesh> mesh;
  bool watertight = false;  // IsWatertight(*mesh), computed once by MakeMesh
  // The holes of a watertight mesh that were closed with triangles of their own (Close). Answers
  // that depend on these triangles are not exact.
  MeshCaps caps = nullptr;
  friend bool operator==(const Mesh& a, const Mesh& b);
};

Mesh MakeMesh(TriangleMesh mesh);

using Shape = std::variant<Sphere, Box, Cylinder, Cone, Capsule, HalfSpace, Plate, Convex, Mesh>;

// True for a mesh whose holes were closed.
bool HasCaps(const Shape& shape);

// The alternatives in the order of the variant: ShapeKind(shape.index()).
enum class ShapeKind {
  kSphere,
  kBox,
  kCylinder,
  kCone,
  kCapsule,
  kHalfSpace,
  kPlate,
  kConvex,
  kMesh
};
inline constexpr int kShapeKindCount = 9;

inline ShapeKind KindOf(const Shape& shape) { return static_cast<ShapeKind>(shape.index()); }

// "sphere", "box", "cylinder", "cone", "capsule", "half_space", "plate", "convex", "mesh".
std::string_view NameOf(ShapeKind kind);

// True for every kind but plate (holes, concave outline) and mesh.
bool IsConvex(ShapeKind kind);

// A shape S placed in a frame F.
template <class S = Shape>
struct Placed {
  Pose X_FS = Pose::Identity();
  S shape;
};

}  // namespace cwm
