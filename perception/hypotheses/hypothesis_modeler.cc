#include "perception/hypotheses/hypothesis_modeler.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/hypotheses/complete_hidden.h"
#include "perception/hypotheses/point_sample.h"
#include "perception/modeler/object_modeler.h"

namespace cwm::perception {
namespace {

double UnexplainedShare(const ObjectModel& found) {
  return static_cast<double>(std::ranges::count(found.part_of_point, kUnexplained)) /
         static_cast<double>(found.part_of_point.size());
}

// The fitted shapes and the ground they stand on.
struct Standing {
  std::optional<Pose> X_LGround;  // empty: no known ground
  ObjectModel found;
  bool reaches_support = false;
};

// Models the hypothesis on its ground. An object that hides the foot of another may seem to carry
// it, so a hypothesis that seems to rest on another is modelled on the support too, and the simpler
// model is kept.
Standing ModelStanding(const OrientedPoints& points, const ObjectHypothesis& hypothesis,
                       const SegmentedScene& measured, const SceneRays& rays,
                       const ModelingOptions& options, const Work& work) {
  const auto model = [&](const std::optional<Pose>& X_LGround) {
    return ModelObject(points, X_LGround, options.noise, options.modeler, work,
                       rays.PassingRaysOf(hypothesis.points, X_LGround, work));
  };
  const double foot_height_m = hypothesis.resting.foot_height_m;
  const std::optional<Pose> X_LFoot = X_LGround(measured, hypothesis.resting);
  Standing best{X_LFoot, model(X_LFoot)};
  if (!X_LFoot || !(foot_height_m > 0) || options.modeler.reduced_effort) return best;
  const double left = UnexplainedShare(best.found);
  // A model of one solid is right already. measured: so it is for 26 of the 31 objects in simulated
  // scenes that seem to rest on others.
  if (best.found.shapes.size() == 1 && left <= 1 - kNearlyAll) return best;
  Standing lower{X_LFoot, {}, true};
  lower.X_LGround->translate(Vector3(0, 0, -foot_height_m));
  lower.found = model(lower.X_LGround);
  const bool is_simpler =
      lower.found.shapes.size() <= best.found.shapes.size() && UnexplainedShare(lower.found) < left;
  return is_simpler ? lower : best;
}

// Makes the sample's model one of all points.
std::shared_ptr<HypothesisModel> Finish(Standing standing, const PointSample& sample,
                                        const OrientedPoints& points, const Work& work) {
  auto model = std::make_shared<HypothesisModel>();
  model->object = std::move(standing.found);
  model->object.part_of_point = sample.PartsOfAllPoints(model->object.part_of_point, work);
  model->reaches_support = standing.reaches_support;
  // Thinned as DetectedObject::points_L requires.
  const float spacing_m = std::max(static_cast<float>(kThinningSpacing_m), Median(points.sigma_m));
  const VoxelGrid thin = VoxelGrid::Build(points.points, spacing_m, work);
  for (std::size_t c = 0; c < thin.size(); ++c) {
    model->thinned_L.push_back(thin.Centroid(c));
    model->bounds_L.extend(model->thinned_L.back());
  }
  return model;
}

PointSample SampleOf(const SegmentedScene& measured, const ObjectHypothesis& hypothesis) {
  return {measured.points, hypothesis.points, hypothesis.node_count};
}

}  // namespace

HypothesisModeler::HypothesisModeler(const SegmentedScene& measured, const Work& work)
    : measured_(measured), work_(work), rays_(measured, work) {}

ModelPtr HypothesisModeler::Model(const ObjectHypothesis& hypothesis,
                                  const ModelingOptions& options) const {
  return ModelIf([](const ObjectModel&) { return true; }, hypothesis, options);
}

ModelPtr HypothesisModeler::ModelIf(const Admission& admits, const ObjectHypothesis& hypothesis,
                                    const ModelingOptions& options) const {
  const PointSample sample = SampleOf(measured_, hypothesis);
  const OrientedPoints points = sample.Points();
  Standing standing = hypothesis.plates.empty()
                          ? ModelStanding(points, hypothesis, measured_, rays_, options, work_)
                          : Standing{{}, ModelStructure(points, hypothesis.plates, work_)};
  if (!admits(standing.found)) return nullptr;
  if (standing.X_LGround && measured_.sight) {
    CompleteHidden({points, *standing.X_LGround}, *measured_.sight, standing.found.shapes);
  }
  auto model = Finish(std::move(standing), sample, points, work_);
  model->is_reduced_effort = options.modeler.reduced_effort;
  return model;
}

ModelPtr HypothesisModeler::ModelGiven(const ObjectHypothesis& hypothesis,
                                       std::vector<ShapePart> shapes) const {
  const PointSample sample = SampleOf(measured_, hypothesis);
  const OrientedPoints points = sample.Points();
  const std::optional<Pose> X_LFoot = X_LGround(measured_, hypothesis.resting);
  auto model = Finish({X_LFoot, ModelFromShapes(points, X_LFoot, std::move(shapes), work_)}, sample,
                      points, work_);
  model->is_given = true;
  return model;
}

}  // namespace cwm::perception
