// Planes longer than any tabletop object: walls, fronts and sides of furniture.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "perception/cloud/work.h"
#include "perception/segmentation/plane_fit.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

// chosen: the tallest object on a counter is a bottle or a box of half a metre.
inline constexpr double kMaxObjectLength_m = 0.5;

// chosen: the cosine of a point's normal with the plane's, 25 degrees: warp and nearby creases bend
// it.
inline constexpr float kFacing_cos = 0.9f;

// The distance that a point of a surface may have from its plane by the sensor's noise and warp:
// the usual one or the largest.
enum class PlaneTolerance { kUsual, kWide };

// True if the point lies on the plane and its normal is near to the plane's (kFacing_cos).
bool IsOnPlane(const Plane& plane, const OrientedPoints& points, std::size_t i,
               PlaneTolerance tolerance);
double ShareOn(const Plane& plane, const OrientedPoints& points,
               std::span<const std::uint32_t> members, PlaneTolerance tolerance);

// The plane that at least the given share of the members lies on, if these reach farther than
// kMaxObjectLength_m.
std::optional<Plane> LongPlane(const OrientedPoints& points, std::span<const std::uint32_t> members,
                               PlaneTolerance tolerance, double min_share);

// Gives connected nodes of class 0 on long planes the classes from 1 on, one for each plane, and
// returns the planes. An object that stands against a wall is connected to it through gaps that
// noise leaves in the crease between them.
std::vector<Plane> LabelLongPlanes(const SurfaceGraph& graph, std::vector<std::int32_t>& classes,
                                   const Work& work);

}  // namespace cwm::perception
