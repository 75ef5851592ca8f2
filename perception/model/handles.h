// Handles: clusters that grow from a shape's surface (paper, section V). No geometric model is
// fitted: "handle geometry can vary greatly".
#pragma once

#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/work.h"
#include "perception/model/object_model.h"

namespace cwm::perception {

// Small solids that look like handles of the largest one are dropped, and their points are nobody's
// again: an ear of a mug is as well a bit of a cylinder. `part_of_point` follows.
void DropSolidsOfHandles(const OrientedPoints& points, double spacing_m,
                         std::vector<ShapePart>& solids, std::vector<std::int32_t>& part_of_point,
                         const Work& work);

// Appends clusters of unexplained points that begin at a solid's surface and leave it, are fairly
// large, elongated and slim, and labels their points.
void FindHandles(const OrientedPoints& points, double spacing_m, ObjectModel& model,
                 const Work& work);

// Appends the clusters as handles of the shape whose surface they begin at, or of none, and labels
// their points.
void AddHandles(const OrientedPoints& points,
                const std::vector<std::vector<std::uint32_t>>& clusters, ObjectModel& model,
                const Work& work);

}  // namespace cwm::perception
