// Planes that reach farther than anything on a table does: walls, fronts and sides of furniture.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "perception/cloud/work.h"
#include "perception/segmentation/plane_fit.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {

// chosen: the tallest thing on a counter is a bottle or a box of half a metre.
inline constexpr double kLongestThing_m = 0.5;

// chosen: of a point's normal with the plane's: 25 degrees, where warp bends it and creases are
// near.
inline constexpr float kFacing_cos = 0.9f;

// How far off its plane a point of a surface may be: usually, or at most, by the sensor's noise and
// warp.
enum class Off { kUsually, kMost };

// Whether the point lies on the plane, and faces where the plane does (kFacing_cos).
bool IsOnPlane(const Plane& plane, const OrientedPoints& points, std::size_t i, Off off);
double ShareOn(const Plane& plane, const OrientedPoints& points,
               std::span<const std::uint32_t> members, Off off);

// The plane through the given share of the members or more, if these reach farther than
// kLongestThing_m.
std::optional<Plane> LongPlane(const OrientedPoints& points, std::span<const std::uint32_t> members,
                               Off off, double least_share);

// Connected nodes of class 0 that long planes run through get classes from 1 on, one for each of
// the planes, which are returned: what stands against a wall hangs together with it by way of the
// gaps that noise leaves in the crease between them.
std::vector<Plane> ClassLongPlanes(const SurfaceGraph& graph, std::vector<std::int32_t>& classes,
                                   const Work& work);

}  // namespace cwm::perception
