// Spaces of the world that no sensor saw and into which objects may extend (ShapePart::hidden).
// They are no obstacles; answers that they could change are labelled kBounded instead of kExact.
#pragma once

#include <cstdint>
#include <vector>

#include "collision/query/query.h"
#include "collision/query/world_filter.h"

namespace cwm::collision {

struct HiddenSpace {
  const WorldObject* object = nullptr;
  std::int32_t part = 0;  // of the object, the shape that may extend into the space
  Pose X_WB = Pose::Identity();
  Box box;
  Aabb bounds_W;
  double depth_m = 0;  // HiddenDepth_m of the part

  // Signed distance from a point, negative inside.
  double Distance_m(const Vector3& p_W) const;
  // A lower bound of the distance between the space and anything in the box.
  double LowerBound_m(const Aabb& bounds_W) const;
  // Distance along the ray to the space, 0 if it begins inside; infinity if it passes by.
  double Entry_m(const Vector3& origin_W, const Vector3& direction_W) const;
};

// Those of all objects that the filter keeps, ordered by object name, then part.
std::vector<HiddenSpace> HiddenSpacesOf(const WorldSnapshot& world, const WorldFilter& filter);

}  // namespace cwm::collision
