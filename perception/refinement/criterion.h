// How well hypotheses explain the points of a scene: what passes compare before and after.
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
// r_i is a point's distance to the nearest surface, sigma_i its noise along the ray, omega the slow
// warp of the sensor, m the points that carry the information of one, N the points of the scene, and k
// the parameters: six of a solid (its pose and sizes, less what the ground tells), and three of an
// object, which could lie anywhere on its support. Shapes and points are in the level frame, in metres.
// Precondition: there are points.
double CostOf(const std::vector<ShapePart>& shapes, const PointSet& points,
              const OrientedPoints& all, const SensorNoise& noise);

// By how much the products cost less than what they replace.
double CriterionGain(const ModelledProposal& modelled);

}  // namespace cwm::perception
