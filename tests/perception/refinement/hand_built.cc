#include "tests/perception/refinement/hand_built.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/geometry/aabb.h"
#include "collision/geometry/signed_distance.h"
#include "perception/hypotheses/hypothesis_modeler.h"
#include "perception/hypotheses/model_hypotheses.h"
#include "perception/refinement/passes.h"
#include "perception/search/model_points.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

const Vector3 kEye(-0.8, -0.3, 0.8);
constexpr float kSigma_m = 0.0015f;
constexpr float kPitch_rad = 0.002f;
constexpr int kDrawsPerSolid = 3000;  // the sensor sees about a third of them
// Enough points that a pass may model two objects anew: it may spend a quarter of all points on
// that.
constexpr double kTableHalf_m = 0.5, kTableSpacing_m = 0.006;
constexpr double kMinFacing = 0.1;  // cosine

ModelingOptions Options() {
  ModelingOptions options;
  return options;
}

double DistanceTo_m(const Placed<>& solid, const Vector3& p) {
  return SignedDistance_m(solid.shape, solid.X_FS.inverse(Eigen::Isometry) * p);
}

void AddPoint(const Vector3& p, const Vector3& n, OrientedPoints& points) {
  points.points.push_back(p.cast<float>());
  points.normals.push_back(n.cast<float>());
  points.sigma_m.push_back(kSigma_m);
  points.normal_sigma_rad.push_back(0.05f);
  points.cloud_index.push_back(static_cast<std::uint32_t>(points.cloud_index.size()));
}

// True if the line of sight from p to the eye runs deeper than `depth_m` inside the solid anywhere.
bool RunsInto(const Vector3& p, const Placed<>& solid, double depth_m) {
  constexpr int kSteps = 100;
  const Vector3 way = kEye - p;
  const Vector3 to_middle = solid.X_FS.translation() - p;
  const double radius_m = 0.5 * TightBounds(solid.shape, Pose::Identity()).sizes().norm();
  const double nearest = std::clamp(to_middle.dot(way) / way.squaredNorm(), 0.0, 1.0);
  if ((to_middle - nearest * way).norm() > radius_m) return false;
  for (int k = 1; k < kSteps; ++k) {
    const Vector3 q = p + static_cast<double>(k) / kSteps * way;
    if (DistanceTo_m(solid, q) < -depth_m) return true;
  }
  return false;
}

ModelPtr ModelOf(const ObjectHypothesis& hypothesis, const OrientedPoints& all,
                 const std::vector<Placed<>>& shapes) {
  auto model = std::make_shared<HypothesisModel>();
  for (const Placed<>& solid : shapes) {
    model->object.shapes.push_back({.X_OS = solid.X_FS, .shape = solid.shape, .fit = FitQuality()});
  }
  for (std::uint32_t i : hypothesis.points) {
    const Vector3 p = all.points[i].cast<double>();
    std::int32_t nearest = kUnexplained;
    double min_m = kDistanceGate_sigma * kSigma_m;
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      const double off_m = std::abs(DistanceTo_m(shapes[k], p));
      if (off_m <= min_m) nearest = static_cast<std::int32_t>(k), min_m = off_m;
    }
    model->object.part_of_point.push_back(nearest);
    model->thinned_L.push_back(all.points[i]);
    model->bounds_L.extend(all.points[i]);
  }
  return model;
}

}  // namespace

HandBuilt::HandBuilt() = default;

HypothesisId HandBuilt::Add(const std::vector<Placed<>>& solids, std::int32_t support) {
  members_.push_back({.solids = solids, .support = support, .on = {}});
  return {static_cast<std::uint32_t>(members_.size() - 1)};
}

HypothesisId HandBuilt::AddOccluder(const Placed<>& solid) { return Add({solid}); }

void HandBuilt::Rest(HypothesisId upper, HypothesisId lower, double foot_height_m) {
  members_[upper.value].on = {lower, foot_height_m};
}

// True if no solid lies between the eye and p. `member` is the one that p belongs to; the line of
// sight may graze its surface.
bool HandBuilt::IsVisible(const Vector3& p, std::size_t member) const {
  constexpr double kInside_m = 0.002;
  for (std::size_t m = 0; m < members_.size(); ++m) {
    for (const Placed<>& solid : members_[m].solids) {
      if (RunsInto(p, solid, m == member ? kInside_m : 0)) return false;
    }
  }
  return true;
}

// Samples points on the surface: random places of the bounds, moved to the nearest surface point.
void HandBuilt::Sample(std::size_t member, OrientedPoints& points, SegmentedScene& scene) const {
  RandomDraws draws(member + 1, 0);
  SegmentedHypothesis& hypothesis = scene.hypotheses.emplace_back();
  hypothesis.supported_by = members_[member].support;
  if (const auto& on = members_[member].on) {
    hypothesis.rests_on = static_cast<std::int32_t>(on->first.value);
    hypothesis.foot_height_m = on->second;
  }
  for (const Placed<>& solid : members_[member].solids) {
    const Vector3 size_m = TightBounds(solid.shape, Pose::Identity()).sizes();
    for (int k = 0; k < kDrawsPerSolid; ++k) {
      Vector3 p_S{draws.Uniform(-0.6, 0.6), draws.Uniform(-0.6, 0.6), draws.Uniform(-0.6, 0.6)};
      const SurfacePoint at = NearestSurfacePoint(solid.shape, p_S.cwiseProduct(size_m));
      const Vector3 p = solid.X_FS * at.nearest, n = solid.X_FS.linear() * at.normal;
      if (n.dot((kEye - p).normalized()) < kMinFacing || !IsVisible(p, member)) continue;
      hypothesis.points.push_back(static_cast<std::uint32_t>(points.size()));
      AddPoint(p, n, points);
    }
  }
  hypothesis.node_count = hypothesis.points.size();
}

SegmentedScene HandBuilt::Segmented() const {
  SegmentedScene scene;
  OrientedPoints points;
  points.viewpoint = kEye;
  for (std::size_t m = 0; m < members_.size(); ++m) Sample(m, points, scene);
  Placed<Plate> table;
  table.shape.outline = {{-kTableHalf_m, -kTableHalf_m},
                         {kTableHalf_m, -kTableHalf_m},
                         {kTableHalf_m, kTableHalf_m},
                         {-kTableHalf_m, kTableHalf_m}};
  table.shape.thickness_m = 0.02;
  SegmentedSupport support{table, {}};
  for (double x = -kTableHalf_m; x < kTableHalf_m; x += kTableSpacing_m) {
    for (double y = -kTableHalf_m; y < kTableHalf_m; y += kTableSpacing_m) {
      const Vector3 p(x, y, 0);
      if (!IsVisible(p, members_.size())) continue;
      support.points.push_back(static_cast<std::uint32_t>(points.size()));
      AddPoint(p, Vector3::UnitZ(), points);
    }
  }
  scene.supports.push_back(std::move(support));
  scene.sight.emplace(points, kPitch_rad * 5);
  scene.points = std::move(points);
  return scene;
}

SceneState HandBuilt::State() const { return SceneState(Segmented()); }

SceneState HandBuilt::StateWith(const std::vector<std::vector<Placed<>>>& shapes) const {
  const SceneState state = State();
  std::vector<ModelPtr> models;
  for (const HypothesisPtr& hypothesis : state.hypotheses()) {
    models.push_back(ModelOf(*hypothesis, state.points(), shapes[hypothesis->id.value]));
  }
  return state.WithModels(models);
}

SceneState HandBuilt::Modelled() const {
  const SceneState state = State();
  const HypothesisModeler modeler(state.measured(), kSerialWork);
  return ModelHypotheses(state, modeler, Options(), kSerialWork).state;
}

Placed<> Standing(const Shape& shape, double x_m, double y_m, double foot_m, double yaw_rad) {
  const double lowest_m = TightBounds(shape, Pose::Identity()).min().z();
  Pose X_LS = Pose::Identity();
  X_LS.translation() = Vector3(x_m, y_m, foot_m - lowest_m);
  X_LS.rotate(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ()));
  return {X_LS, shape};
}

namespace {

// The names of all passes except `pass`, which are to be disabled.
std::vector<std::string> AllBut(std::string_view pass) {
  std::vector<std::string> others = PassNames();
  std::erase(others, std::string(pass));
  return others;
}

}  // namespace

RefinedScene RunAlone(const SceneState& state, std::string_view pass) {
  const HypothesisModeler modeler(state.measured(), kSerialWork);
  const ModelingOptions options = Options();
  return Refine(state, RefinementPasses(), AllBut(pass),
                {.options = options, .modeler = modeler, .work = kSerialWork});
}

std::vector<Proposal> ProposalsOf(const SceneState& state, std::string_view pass) {
  const HypothesisModeler modeler(state.measured(), kSerialWork);
  const ModelingOptions options = Options();
  const auto& passes = RefinementPasses();
  const auto found =
      std::ranges::find_if(passes, [&](const auto& one) { return one->Name() == pass; });
  return (*found)->Propose(state, {.options = options, .modeler = modeler, .work = kSerialWork});
}

}  // namespace cwm::perception
