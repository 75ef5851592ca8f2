// Fits one closed solid, caps and faces included, to all points of an object at once. It uses no
// normals, so it also works for shapes that are narrower than the windows normals are estimated in.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "perception/primitive_fit/primitive_kind.h"

namespace cwm::perception {

// measured: neighbouring residuals are correlated, so 240 of 3 000 measured points are enough to
// choose between kinds.
inline constexpr std::size_t kUsedPoints = 240;

// chosen: added to the information of each parameter so that a step of an unconstrained one stays
// finite. Any small number would do.
inline constexpr double kMinInformation = 1e-9;

struct PrimitiveFit {
  PrimitiveKind kind = PrimitiveKind::kBall;
  PrimitiveParameters parameters;
  Solid solid;       // its inliers lie within their distance gates
  double value = 0;  // as FitScore::value, plus the prior of a cone's slope
  double loss = 0;   // as FitScore::loss
};

// The score of several solids together. Each point counts for the nearest of them.
struct FitScore {
  double value = 0;  // as Criterion::value, plus the cost of rays deep inside
  double loss = 0;   // robust loss per point
};
FitScore FitScoreOf(const std::vector<Solid>& solids, int parameters, const FitContext& context);

// Minimises a robust loss (Geman and McClure 1987) of the points' signed distances to the surface
// of the solid, from starts that the points and the `known` solids suggest. Rays that passed the
// object are added in a second fit if the first one would win without them. Empty if no ground is
// known, if no start is within the limits of the options, if after a few steps the best start's
// loss is still far above that of the alternative, or as soon as too many points lie off the solid.
std::optional<PrimitiveFit> FitPrimitive(PrimitiveKind kind, const std::vector<Solid>& known,
                                         const FitScore& alternative, const FitContext& context);

// Refines the round fit that was chosen on more of the points and on the rays near it, each point
// weighted by its noise across the surface. Boxes, and solids of which only the lid is seen, end
// where their points end and stay as they are. Value and loss stay those by which the fit was
// chosen.
void RefineOnMorePoints(const FitContext& context, PrimitiveFit& fit);

// The covariance of the parameters, from independent noise and from the sensor's slow warp.
Eigen::MatrixXd CovarianceOf(const PrimitiveFit& fit, const FitContext& context);

// Standard deviations of the shape's coefficients, as in Solid::parameter_sigma.
std::vector<double> CoefficientSigmas(const PrimitiveFit& fit, const Eigen::MatrixXd& covariance,
                                      const FitContext& context);

}  // namespace cwm::perception
