// How far points lie from a whole solid, and what of that their noise and the sensor's slow warp
// account for.
#pragma once

#include <Eigen/Core>

#include "perception/fit/shape_fit.h"
#include "perception/whole/whole_starts.h"

namespace cwm::perception {

// Of a surface over two coordinates: 1, x, y, x^2, x y, y^2.
using QuadricTerms = Eigen::Matrix<double, 6, 1>;

// Of points against a surface: signed, in standard deviations, and by how much each changes with
// the range, which is what the sensor's warp moves.
struct Misfit {
  Eigen::VectorXd residuals, per_range;
};
Misfit MisfitOf(const WholeSolid& solid, const Eigen::VectorXd& residuals,
                const PointsOnGround& points);

// By how much the signed distance of p to the surface grows as it moves away from the viewpoint:
// between -1 and 1, the cosine of the ray's incidence.
double PerRange(const Shape& shape, const Pose& X_SG, const Vector3& p, const Vector3& viewpoint);

// The criterion of the squares that are left when the slow warp takes what it is likely to take of
// them.
double ValueOf(const Misfit& misfit, int parameters, const PointsOnGround& points,
               const FitContext& context);

// Gives the points the noise that they have across the surface that they lie on, which the sensor
// scatters them about along its ray and across.
void TakeNoiseAcross(const WholeSolid& solid, const SensorNoise& noise, PointsOnGround& points);

}  // namespace cwm::perception
