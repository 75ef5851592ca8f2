// Residuals of points from a solid, and the share of them that noise and the sensor's slow warp
// explain.
#pragma once

#include <Eigen/Core>

#include "perception/fit/shape_fit.h"
#include "perception/primitive_fit/primitive_fit_starts.h"

namespace cwm::perception {

// Terms of a quadric surface over two coordinates: 1, x, y, x^2, x y, y^2.
using QuadricTerms = Eigen::Matrix<double, 6, 1>;

// Residuals of points from a surface, signed, in standard deviations; and how much the signed
// distance of each changes per metre of range, which is the direction that the sensor's warp moves
// points in.
struct Misfit {
  Eigen::VectorXd residuals, along_ray;
};
Misfit MisfitOf(const PlacedPrimitive& solid, const Eigen::VectorXd& residuals,
                const PointsOnGround& points);

// The change of p's signed distance to the surface per metre away from the viewpoint: between -1
// and 1, the cosine of the ray's incidence.
double DerivativeAlongRay(const Shape& shape, const Pose& X_SG, const Vector3& p,
                          const Vector3& viewpoint);

// The criterion's value of the squared residuals that are left after the most likely slow warp is
// removed from them.
double ValueOf(const Misfit& misfit, int parameters, const PointsOnGround& points,
               const FitContext& context);

// Replaces the standard deviations of the points by those across the surface they lie on. The
// sensor scatters points both along its ray and sideways.
void SetNoiseAcrossSurface(const PlacedPrimitive& solid, const SensorNoise& noise,
                           PointsOnGround& points);

}  // namespace cwm::perception
