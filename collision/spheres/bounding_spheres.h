// Spheres that together contain the collision geometry of a link.
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
  const TriangleTree* tree = nullptr;  // null unless the piece is a mesh
};

// Returns spheres that together contain every point of every piece: its surface, the inside of a
// solid and of a closed mesh, and the whole bounding box of an open mesh, so that no open surface
// can wrap around a state that is clear of the spheres. There are at most kMaxSpheres; with that
// many pieces or more, there is one per piece, around its bounding box. The same pieces give the
// same spheres. Empty for a half-space, and if `work` stopped the construction.
//
// Starting from the boxes of the pieces, the cell with the largest sphere is halved again and
// again. The part of a solid inside a cell lies in the hull of its surface there and of the cell's
// corners that are inside the solid; the cell's sphere contains this hull. Round shapes are
// approximated by facets, and their spheres grow by the deviation of the facets.
inline constexpr std::size_t kMaxSpheres = 32;
std::optional<std::vector<LinkSphere>> FitBoundingSpheres(std::span<const LinkPiece> pieces,
                                                          WorkCounter* work = nullptr);

}  // namespace cwm::collision
