// Measures how well hypotheses explain the points of a scene, to compare them before and after a
// pass.
#pragma once

#include <vector>

#include "perception/cloud/sensor_noise.h"
#include "perception/hypotheses/scene_state.h"
#include "perception/refinement/pass.h"

namespace cwm::perception {

// Schwarz's criterion (1978) over a part of a scene, in nats; less is better:
//
//   cost = 1/2 (sum_i min(r_i^2 / (sigma_i^2 + omega^2), 9) / m + k ln(N / m))
//
// r_i is a point's distance from the nearest surface, sigma_i its noise along the ray, and omega
// the slow warp of the sensor. Each point's term is truncated; points of handles, which have no
// surface, count like unexplained ones. m is the number of points that carry the information of one
// (OrientedPoints::points_per_sample), and N the number of points of the scene. k is the number of
// parameters: six per solid (its pose and sizes, less those that the ground determines), and three
// per object, which may be anywhere on its support. A nat is half of the unit of the criterion in
// fit/shape_fit.h, which leaves out the factor 1/2. Shapes and points are in the level frame, in
// metres. Precondition: there are points.
double CostOf(const std::vector<ShapePart>& shapes, const PointSet& points,
              const OrientedPoints& all, const SensorNoise& noise);

// The cost of the replaced hypotheses minus the cost of the products.
double CriterionGain(const ModelledProposal& modelled);

}  // namespace cwm::perception
