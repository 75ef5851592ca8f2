// How far an object may continue behind a face of which nothing but the front was seen.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/hybrid_model.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

// A measured solid of an object, in the level frame.
struct SolidOfObject {
  std::size_t object = 0;
  Pose X_LS = Pose::Identity();
  const ShapePart* part = nullptr;
  Aabb bounds_L;
};

// The evidence about the space behind faces, in the level frame.
struct HiddenSpaceEvidence {
  const SightMap* sight = nullptr;     // null: not all points were seen from one place
  std::optional<Pose> X_LGround = {};  // z = 0 is the plane that the object stands on, z up
  double tolerance_m = 0;              // a place nearer than this to a return is on its surface
  std::span<const SolidOfObject> solids =
      {};                  // of all objects; what one fills is not another one's
  std::size_t object = 0;  // the object in question, whose own solids do not count
};

// True for plates and thin boxes: only a face was seen, and the depth of the solid was assumed.
bool IsFace(const Shape& shape);

// Sets ShapePart::hidden of
//   - plates and thin boxes, whose depth was assumed: from the face backwards, as deep as no more
//     than half of each layer of 1 cm is seen through or in the ground. They become COMPLETED.
//     Boxes thinner than 3 cm are treated alike, but keep their role;
//   - other boxes, if there is a sight map: beyond each side, as far as no more than 3 % of each
//     layer is seen through, in the ground or in another object. A box has none if an edge on its
//     far side was seen.
// 1 m at most; less than 3 cm does not count. The shapes are placed in a frame at `X_LO`.
void FindHiddenDepth(const Pose& X_LO, const HiddenSpaceEvidence& evidence,
                     std::vector<ShapePart>& shapes);

}  // namespace cwm::perception
