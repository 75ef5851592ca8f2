// The horizontal planes that things stand on (paper, section III steps 2 to 4).
#pragma once

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
CoarseCloud MakeCoarseCloud(const OrientedPoints& nodes, const Work& work = {});

// The same cells of an image, of as many of its points as they need: enough to find planes by.
CoarseCloud SketchCoarseCloud(const MeasuredPoints& image, const Work& work = {});

// chosen: of a level cell's normal to up: the normals of cells scatter by a few degrees, and so do
// floors and ups that are given.
inline constexpr double kMaxTilt_rad = 12 * std::numbers::pi / 180;

// derived: a place that cannot hold an object of 15 x 15 cm is not worth being a support of its
// own.
inline constexpr double kMinSupport_m2 = kClosing_m * kClosing_m;

// chosen: of what is something of its own, and of its footprint: a spray can's rim seen from the
// front.
inline constexpr double kMinThing_m2 = 2e-4;

// chosen: besides 3 sigma, how high above what it stands on the lowest points of a thing are seen:
// a crease takes the others.
inline constexpr double kFootHeight_m = 0.02;

// A plane with `up . normal` > 0 and the cells that lie on it.
struct SupportPlane {
  Plane plane;
  std::vector<std::uint32_t> cells;  // of the coarse grid, ascending
  double area_m2 = 0;                // of those cells
};

// Candidates whose normals are up within kMaxTilt_rad, or as far as they are known where one looks
// along the plane, clustered by connectivity and height, with a robust plane in each, in parallel.
// Coplanar pieces (3 degrees, 1 cm) whose gap is closed (GapIsClosed) are one support; gaps
// narrower than a coarse cell divide no piece. Small level patches over a larger support are tops
// of objects, not supports, unless one sees under them; neither are planes through what fills
// space. Largest first. `sight` is null when nobody knows where the sensor was.
std::vector<SupportPlane> FindSupportPlanes(const CoarseCloud& coarse, const Vector3& up,
                                            const SightMap* sight, const Work& work);

}  // namespace cwm::perception
