// One closed solid fitted to all points of an object at once, caps and faces included. It asks no
// normals, so it tells shapes that are no wider than the windows which normals are estimated in.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "perception/whole/whole_kind.h"

namespace cwm::perception {

// measured: neighbouring residuals are correlated, so 240 of 3 000 measured points tell kinds from
// each other.
inline constexpr std::size_t kUsedPoints = 240;

// chosen: of a parameter that no point tells, so that its step stays finite; any small number would
// do.
inline constexpr double kMinInformation = 1e-9;

struct WholeFit {
  WholeKind kind = WholeKind::kBall;
  WholeParameters parameters;
  Solid solid;       // its inliers are the points within their distance gates
  double value = 0;  // as Account::value, and with how unlikely a cone's slope is
  double loss = 0;   // as Account::loss
};

// Of solids together, each point counting for the nearest of them.
struct Account {
  double value = 0;  // as Criterion::value, with the rays that run deep in the solids
  double loss = 0;   // robust, per point
};
Account AccountOf(const std::vector<Solid>& solids, int parameters, const FitContext& context);

// Minimises a robust loss (Geman and McClure 1987) of the points' signed distances to the solid's
// surface, from what the points and the `known` solids suggest. Nothing without a ground, where no
// start is within the limits of the options, where the best start's loss per point is still far
// above the rival's after a few steps, or where it is soon clear that a tenth of the points or more
// would lie off the solid. One that would win but for the rays that passed the object is moved out
// of their way.
std::optional<WholeFit> FitWhole(WholeKind kind, const std::vector<Solid>& known,
                                 const Account& rival, const FitContext& context);

// Moves a round fit that is kept to where more of the points, and the rays that come near it, have
// it, each point counting by its noise across the surface. Boxes and lids alone, which end where
// their points end, stay as they are. Value and loss stay those that it was chosen by.
void FitToMore(const FitContext& context, WholeFit& fit);

// Of the parameters: independent noise and the sensor's slow warp.
Eigen::MatrixXd CovarianceOf(const WholeFit& fit, const FitContext& context);

// As Solid::parameter_sigma.
std::vector<double> CoefficientSigmas(const WholeFit& fit, const Eigen::MatrixXd& covariance,
                                      const FitContext& context);

}  // namespace cwm::perception
