// The bounds of a support (paper, section III step 4).
#pragma once

#include <span>

#include "collision/geometry/shape.h"
#include "perception/cloud/oriented_points.h"
#include "perception/scene/plane_fit.h"

namespace cwm::perception {

// A plate's thickness where only its top was seen.
inline constexpr double kPlateThickness_m = 0.02;

// The plate below a plane that carries these points, its frame's origin in the middle of the
// outline, z along the plane's normal, x as near to the x of the points' frame as can be. Nothing
// when the points span no area.
std::optional<Placed<Plate>> MakeSupportPlate(const Plane& plane, const OrientedPoints& points,
                                              std::span<const std::uint32_t> members);

// Distance of a point's projection to the outline, metres: 0 or less inside.
double OutsideOutline_m(const Placed<Plate>& plate, const Vector3& point);

}  // namespace cwm::perception
