// Reconstructs surfaces for points that no shape explains: resampling by moving least squares, then
// triangulation by an advancing front of local projections (paper, section V; Marton, Rusu and
// Beetz, "On Fast Surface Reconstruction Methods for Large and Noisy Point Clouds", ICRA 2009).
#pragma once

#include <vector>

#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/oriented_points.h"
#include "perception/cloud/tolerances.h"
#include "perception/cloud/work.h"

namespace cwm::perception {

struct SurfaceOptions {
  // Distance between vertices after thinning; at least the median noise of the points.
  double spacing_m = kThinningSpacing_m;
  // Per call, thus per object or support; the spacing is widened until the limit holds.
  int max_triangles = 10000;
};

struct Surface {
  TriangleMesh mesh;  // validated: no degenerate triangle, normals towards the viewpoint, no NaN
  std::vector<std::uint32_t> explained;  // input points within ExplainedWithin_m of the mesh
};

// Points in no triangle (fewer than three, or isolated) are covered by small triangles of the size
// of the spacing, so that collision checks include every finite point. Throws Stopped when `work`
// is stopped.
Surface ReconstructSurface(const OrientedPoints& points, const SurfaceOptions& options,
                           const Work& work = {});

}  // namespace cwm::perception
