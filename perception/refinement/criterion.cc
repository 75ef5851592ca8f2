#include "perception/refinement/criterion.h"

#include <algorithm>
#include <cmath>

#include "perception/fit/shape_fit.h"
#include "perception/refinement/evidence.h"
#include "perception/search/model_points.h"

namespace cwm::perception {
namespace {

// derived: the pose and the sizes of a solid, less those that the ground determines; an object's
// place on its support.
constexpr double kParametersOfSolid = 6, kParametersOfObject = 3;

}  // namespace

double CostOf(const std::vector<ShapePart>& shapes, const PointSet& points,
              const OrientedPoints& all, const SensorNoise& noise) {
  const double warp_m = noise.WarpSigma_m();
  // The sampled points represent all points.
  const PointSet some = Subsampled(points, kMaxComparedPoints);
  double squares = 0;
  for (const std::uint32_t i : some) {
    const double off_m = DistanceToShapes_m(shapes, all.points[i].cast<double>());
    const double off = off_m / std::hypot(double{all.sigma_m[i]}, warp_m);
    squares += std::min(kTruncatedSquare, off * off);
  }
  if (!some.empty()) {
    squares *= static_cast<double>(points.size()) / static_cast<double>(some.size());
  }
  const double parameters =
      kParametersOfObject + kParametersOfSolid * static_cast<double>(shapes.size());
  const auto per_sample = double{all.points_per_sample};
  const double samples = std::max(2.0, static_cast<double>(all.size()) / per_sample);
  return 0.5 * (squares / per_sample + parameters * std::log(samples));
}

double CriterionGain(const ModelledProposal& modelled) {
  const OrientedPoints& all = modelled.state.points();
  const SensorNoise& noise = modelled.context.options.noise;
  double gain = 0;
  for (const Consumed& consumed : modelled.proposal.consumes) {
    const ObjectHypothesis& before = modelled.state.Get(consumed.id);
    gain += CostOf(before.model->shapes(), before.points, all, noise);
  }
  for (std::size_t k = 0; k < modelled.products.size(); ++k) {
    const PointSet& points = modelled.proposal.products[k].points;
    gain -= CostOf(modelled.products[k]->shapes(), points, all, noise);
  }
  return gain;
}

}  // namespace cwm::perception
