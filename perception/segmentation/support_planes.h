// The level planes that objects stand on (paper, section III steps 2 to 4).
#pragma once

#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "perception/cloud/measured_points.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/cloud/work.h"
#include "perception/segmentation/plane_fit.h"
#include "perception/segmentation/sight_map.h"
#include "perception/segmentation/support_gaps.h"

namespace cwm::perception {

// The downsampled cloud that supports are searched in.
struct CoarseCloud {
  VoxelGrid grid;        // over the graph's nodes
  OrientedPoints cells;  // one per cell
};
// Cells as wide as the noise requires, but not wider than `max_cell_m`.
CoarseCloud MakeCoarseCloud(const OrientedPoints& nodes, const Work& work = {},
                            float max_cell_m = std::numeric_limits<float>::infinity());

// The same cells of an image, from a subset of its points that suffices to find planes.
CoarseCloud MakeSubsampledCoarseCloud(const MeasuredPoints& image, const Work& work = {},
                                      float max_cell_m = std::numeric_limits<float>::infinity());

// chosen: the largest angle between a level cell's normal and up: normals of cells scatter by a few
// degrees, and floors and given ups are inclined by as much.
inline constexpr double kMaxTilt_rad = 12 * std::numbers::pi / 180;

// derived: a support must have room for an object of 15 x 15 cm.
inline constexpr double kMinSupport_m2 = kClosing_m * kClosing_m;

// chosen: the least area of an object, and of its footprint: the rim of a spray can seen from the
// front.
inline constexpr double kMinObjectArea_m2 = 2e-4;

// chosen: how high above its support, besides 3 sigma, the lowest points of an object are seen; the
// crease takes lower ones.
inline constexpr double kFootHeight_m = 0.02;

// A plane with `up . normal` > 0 and the cells that lie on it.
struct SupportPlane {
  Plane plane;
  std::vector<std::uint32_t> cells;  // indices into the coarse grid, ascending
  double area_m2 = 0;                // of the cells
};

// Finds support planes. Cells whose normals are up within kMaxTilt_rad, or within their error if
// seen at a grazing angle, are clustered by connectivity and height, and a robust plane is fitted
// in each cluster, in parallel. Coplanar pieces (3 degrees, 1 cm) whose gap is closed (IsGapClosed)
// are one support; gaps narrower than a coarse cell do not divide a piece. Small level patches over
// a larger support are tops of objects, not supports, unless the sensor sees under them. Planes
// through cells that fill space are not supports either. Largest first. `sight` is null if the
// sensor's place is unknown.
std::vector<SupportPlane> FindSupportPlanes(const CoarseCloud& coarse, const Vector3& up,
                                            const SightMap* sight, const Work& work);

}  // namespace cwm::perception
