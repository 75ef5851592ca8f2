// Finds handles: clusters that grow from a shape's surface (paper, section V). No geometric model
// is fitted, because "handle geometry can vary greatly". Clusters that lie on the ground are no
// handles; `ground` is in the points' frame.
#pragma once

#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/work.h"
#include "perception/fit/ground.h"
#include "perception/handles/vessel_handles.h"
#include "perception/model/object_model.h"

namespace cwm::perception {

using Clusters = std::vector<std::vector<std::uint32_t>>;  // indices of points, ascending

// Drops small solids that look like handles of the largest solid, since the ear of a mug also fits
// a bit of a cylinder. Their points become unexplained, except those on the surface of the largest
// solid, which become its points.
void DropSolidsOfHandles(const OrientedPoints& points, double spacing_m, const Ground& ground,
                         std::vector<ShapePart>& solids, std::vector<std::int32_t>& part_of_point,
                         const Work& work);

// Returns handles of the vessel that are not part of a larger solid, such as an edge of a box. They
// are sought among all points and then among the unexplained ones, because a solid may explain what
// touches a handle.
Clusters HandlesOfVessel(const Vessel& vessel, const OrientedPoints& points, const Ground& ground,
                         const std::vector<ShapePart>& solids,
                         const std::vector<std::int32_t>& part_of_point, const Work& work);

// Makes the points of the clusters unexplained, and drops solids that lose more than half of their
// points.
void RemoveFromSolids(const Clusters& clusters, std::vector<ShapePart>& solids,
                      std::vector<std::int32_t>& part_of_point);

// Appends clusters of unexplained points that begin at a solid's surface and leave it, and that are
// fairly large, elongated and slim; labels their points. A cluster is no handle if its nearest
// shape is a plate, or explains some points but less than twice as many as the cluster has.
void FindHandles(const OrientedPoints& points, double spacing_m, const Ground& ground,
                 ObjectModel& model, const Work& work);

// Appends the clusters as handles of the shape at whose surface they begin, or of none; labels
// their points.
void AddHandles(const OrientedPoints& points, const Clusters& clusters, ObjectModel& model,
                const Work& work);

}  // namespace cwm::perception
