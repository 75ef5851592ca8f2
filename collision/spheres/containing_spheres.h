// Spheres that together contain what a link is made of.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "collision/geometry/shape.h"
#include "collision/kernels/triangle_tree.h"
#include "collision/robot/sphere_model.h"

namespace cwm::collision {

struct LinkPiece {
  Pose X_LP = Pose::Identity();
  const Shape* shape = nullptr;
  const TriangleTree* tree = nullptr;  // of a mesh
};

// No more than kMostSpheres, but of that many pieces or more one each, around its box. Every point of every piece lies in one of them: the surface, and of
// solids and closed meshes the inside, of open ones the whole box around them, so that what is
// clear of the spheres is not wrapped in an open surface either. By construction: the link's box is
// halved again and again where its spheres are largest; what of a solid lies in a cell is contained
// in the hull of its surface there and of those corners of the cell that are inside; a sphere
// around these points contains the hull. Round shapes enter by facets, and their spheres grow by
// what those deviate. The same pieces give the same spheres. Nothing for a half-space, or where `work`
// ended it.
inline constexpr std::size_t kMostSpheres = 32;
std::optional<std::vector<LinkSphere>> SpheresAround(std::span<const LinkPiece> pieces,
                                                     WorkCounter* work = nullptr);

}  // namespace cwm::collision
