// Measures the rim of a round face. The edge of a disc constrains the centre and the radius of the
// wall below it better than the wall's own curvature does.
#pragma once

#include <optional>

#include "perception/fit/shape_fit.h"
#include "perception/search/cone_model.h"

namespace cwm::perception {

// chosen: the largest scatter of a rim's edge as a share of its radius; a square's edge scatters by
// 0.1.
inline constexpr double kMaxRimScatter = 0.05;

// A measured rim, in the frame of the model points.
struct Rim {
  Vector3 center = Vector3::Zero();  // on the face
  double radius_m = 0;
  Matrix3 covariance = Matrix3::Zero();  // centre along `basis` columns 0 and 1, then radius
  Matrix3 basis = Matrix3::Identity();   // column 2 is the face's normal
  double scatter_m = 0;                  // robust standard deviation of the sectors' edges
  double seen = 0;                       // share of the circle whose edge agrees with it
};

// Measures the edge of `face`, a disc about the axis of `wall` whose cross section is known to
// `wall_sigma_m`, sector by sector, where the wall below turns away from the sensor: there the disc
// ends at a depth jump. The edge of a sector lies where a sharp edge of the density inside it would
// hold as many points as were measured, so that noise across the ray and the spacing of the pixels
// cancel. Empty if too little of the edge is seen, or if it is no circle.
std::optional<Rim> MeasureRim(const PlaneModel& face, const ConeModel& wall, double wall_sigma_m,
                              const FitContext& context);

// The same for a wall normal to the face of which only this end is known.
std::optional<Rim> MeasureRim(const PlaneModel& face, const FitContext& context);

// Returns the wall that agrees best with its own fit of this covariance and with its rim (a Kalman
// update), and updates `covariance`. Both stay unchanged if wall and rim contradict each other. M
// is CylinderModel or ConeModel.
template <class M>
M FuseRim(const M& wall, const Rim& rim, Eigen::MatrixXd& covariance);

extern template CylinderModel FuseRim(const CylinderModel&, const Rim&, Eigen::MatrixXd&);
extern template ConeModel FuseRim(const ConeModel&, const Rim&, Eigen::MatrixXd&);

}  // namespace cwm::perception
