// Handles: clusters that grow from a shape's surface (paper, section V). No geometric model is
// fitted: "handle geometry can vary greatly". What lies on the ground, given in the points' frame, is
// none.
#pragma once

#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/work.h"
#include "perception/fit/ground.h"
#include "perception/handles/vessel_handles.h"
#include "perception/model/object_model.h"

namespace cwm::perception {

using Clusters = std::vector<std::vector<std::uint32_t>>;  // indices of points, ascending

// Small solids that look like handles of the largest one are dropped, and their points are nobody's
// again: an ear of a mug is as well a bit of a cylinder. `part_of_point` follows.
void DropSolidsOfHandles(const OrientedPoints& points, double spacing_m, const Ground& ground,
                         std::vector<ShapePart>& solids, std::vector<std::int32_t>& part_of_point,
                         const Work& work);

// Handles of the vessel that are no part of a larger solid (an edge of a box is none), among all
// points and, where a solid explains what touches a handle, among the points that none explains.
Clusters HandlesOfVessel(const Vessel& vessel, const OrientedPoints& points, const Ground& ground,
                         const std::vector<ShapePart>& solids,
                         const std::vector<std::int32_t>& part_of_point, const Work& work);

// The points of the clusters are nobody's again, and solids that have little else are dropped.
void TakeFromSolids(const Clusters& clusters, std::vector<ShapePart>& solids,
                    std::vector<std::int32_t>& part_of_point);

// Appends clusters of unexplained points that begin at a solid's surface and leave it, are fairly
// large, elongated and slim, and labels their points.
void FindHandles(const OrientedPoints& points, double spacing_m, const Ground& ground,
                 ObjectModel& model, const Work& work);

// Appends the clusters as handles of the shape whose surface they begin at, or of none, and labels
// their points.
void AddHandles(const OrientedPoints& points, const Clusters& clusters, ObjectModel& model,
                const Work& work);

}  // namespace cwm::perception
