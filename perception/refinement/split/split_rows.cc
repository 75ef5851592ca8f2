#include "perception/refinement/split/split_rows.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <map>
#include <numbers>
#include <optional>

#include "collision/geometry/aabb.h"
#include "perception/cloud/quantile.h"
#include "perception/model/model_points.h"
#include "perception/refinement/evidence.h"
#include "perception/refinement/split/wall_profile.h"

namespace cwm::perception {
namespace {

constexpr int kMaxTrials = 12;
constexpr std::size_t kPointsDivisor = 4;
constexpr double kStep_m = 0.003;  // along the row: two pixels at 0.8 m
constexpr std::size_t kMinInStep = 6;
constexpr double kMinRow_m = 0.05;    // two thin books and what noise blurs
constexpr double kMinPart_m = 0.015;  // the thinnest book that shows five pixels
constexpr float kMaxWall_sin = 0.5f;  // a wall's normal is no farther from level
constexpr double kMinFacing = 0.35;   // cosine between the normal and the way out of the front
constexpr double kFrontTolerance_m = 0.0003;  // of the median of a step: quantisation
// An object that one solid explains so far is cut only where the cut pays for its parameters; what is
// several solids already only gets them as objects of their own.
constexpr double kOneSolid = 0.96;
// From the ground to a part: noise, and what a fit without a view of the foot is wrong by.
constexpr double kMaxFootGap_m = 0.01;
constexpr double kMinExplained = 0.85;  // of a part's points, by one solid

// Points of an object over its ground.
struct Measured {
  std::vector<Vector3> p;  // in the frame of the ground: z up
  std::vector<Vector3> n;
  std::vector<double> sigma_m;
};

Measured OverGround(const SceneState& state, const ObjectHypothesis& object,
                    const Pose& X_GroundL) {
  const OrientedPoints& all = state.points();
  Measured measured;
  for (const std::uint32_t i : object.points) {
    measured.p.push_back(X_GroundL * all.points[i].cast<double>());
    measured.n.push_back(X_GroundL.linear() * all.normals[i].cast<double>());
    measured.sigma_m.push_back(double{all.sigma_m[i]});
  }
  return measured;
}

// The direction of upright faces that are at right angles: that of the mean of fourfold angles.
std::optional<double> YawOfFaces(const Measured& measured) {
  constexpr double kMinLength = 0.3;  // of the mean: round walls have none
  std::complex<double> sum = 0;
  std::size_t count = 0;
  for (const Vector3& n : measured.n) {
    if (!(std::abs(n.z()) <= kMaxWall_sin)) continue;
    sum += std::polar(1.0, 4 * std::atan2(n.y(), n.x()));
    ++count;
  }
  if (count == 0 || std::abs(sum) < kMinLength * static_cast<double>(count)) return std::nullopt;
  return std::arg(sum) / 4;
}

// The direction of the greatest extent in the plan.
double YawOfExtent(const Measured& measured) {
  Vector2 mean = Vector2::Zero();
  for (const Vector3& p : measured.p) mean += p.head<2>() / static_cast<double>(measured.p.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Vector3& p : measured.p) {
    const Vector2 d = p.head<2>() - mean;
    spread += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spread);
  const Vector2 longest = solver.eigenvectors().col(1);
  return std::atan2(longest.y(), longest.x());
}

// The front of a row that runs along `along`, seen from `outward`.
std::vector<ProfilePoint> FrontOf(const Measured& measured, const Vector2& along,
                                  const Vector2& outward, double points_per_sample) {
  struct Step {
    std::vector<double> offsets_m;
    double along_m = 0, sigma_m = 0;
  };
  std::map<long, Step> steps;
  for (std::size_t k = 0; k < measured.p.size(); ++k) {
    const Vector3& n = measured.n[k];
    if (!(std::abs(n.z()) <= kMaxWall_sin) || n.head<2>().dot(outward) < kMinFacing) continue;
    const double at_m = along.dot(measured.p[k].head<2>());
    Step& step = steps[std::lround(std::floor(at_m / kStep_m))];
    step.offsets_m.push_back(outward.dot(measured.p[k].head<2>()));
    step.along_m += at_m;
    step.sigma_m += measured.sigma_m[k];
  }
  constexpr double kMedian = 1.253;  // of normal noise: sigma of a median over that of a mean
  std::vector<ProfilePoint> front;
  for (auto& [index, step] : steps) {
    if (step.offsets_m.size() < kMinInStep) continue;
    const auto count = static_cast<double>(step.offsets_m.size());
    const double independent = std::max(1.0, count / points_per_sample);
    front.push_back({.along_m = step.along_m / count,
                     .offset_m = Quantile(std::move(step.offsets_m), 0.5),
                     .sigma_m = std::hypot(kMedian * step.sigma_m / count / std::sqrt(independent),
                                           kFrontTolerance_m)});
  }
  return front;
}

// Seams that leave parts as wide as objects are; the ends of the front are those of the row.
std::vector<double> PartSeams(const std::vector<ProfilePoint>& front) {
  std::vector<double> seams;
  if (front.empty() || front.back().along_m - front.front().along_m < kMinRow_m) return seams;
  double begin_m = front.front().along_m;
  for (const double seam_m : SeamsOf(front)) {
    if (seam_m - begin_m < kMinPart_m || front.back().along_m - seam_m < kMinPart_m) continue;
    seams.push_back(seam_m);
    begin_m = seam_m;
  }
  return seams;
}

Proposal SplitAt(const ObjectHypothesis& object, const Measured& measured, const Vector2& along,
                 const std::vector<double>& seams) {
  std::vector<PointSet> parts(seams.size() + 1);
  for (std::size_t k = 0; k < measured.p.size(); ++k) {
    const double at_m = along.dot(measured.p[k].head<2>());
    const auto seam = std::ranges::lower_bound(seams, at_m);
    parts[static_cast<std::size_t>(seam - seams.begin())].push_back(object.points[k]);
  }
  Proposal proposal{.consumes = {{object.id}}};
  for (PointSet& part : parts) {
    Product product{
        .points = std::move(part), .resting = object.resting, .expects = Expectation::kOneObject};
    product.node_count = NodesOf(object, product.points.size());
    proposal.products.push_back(std::move(product));
  }
  return proposal;
}

// One for each direction of a row, with the most parts first.
std::vector<Proposal> SplitsOf(const SceneState& state, const ObjectHypothesis& object) {
  const Pose X_GroundL = X_LGround(state.measured(), object.resting)->inverse(Eigen::Isometry);
  const Measured measured = OverGround(state, object, X_GroundL);
  const Vector3 eye = X_GroundL * state.points().viewpoint;
  std::vector<double> yaws_rad = {YawOfExtent(measured)};
  if (const std::optional<double> yaw_rad = YawOfFaces(measured)) {
    yaws_rad = {*yaw_rad, *yaw_rad + 0.5 * std::numbers::pi};
  }
  Vector2 middle = Vector2::Zero();
  for (const Vector3& p : measured.p) {
    middle += p.head<2>() / static_cast<double>(measured.p.size());
  }
  std::vector<Proposal> proposals;
  for (const double yaw_rad : yaws_rad) {
    const Vector2 along(std::cos(yaw_rad), std::sin(yaw_rad));
    Vector2 outward(-along.y(), along.x());
    if (outward.dot(eye.head<2>() - middle) < 0) outward = -outward;
    const std::vector<double> seams =
        PartSeams(FrontOf(measured, along, outward, double{state.points().points_per_sample}));
    if (seams.empty()) continue;
    Proposal proposal = SplitAt(object, measured, along, seams);
    const bool has_empty = std::ranges::any_of(
        proposal.products, [](const Product& product) { return product.points.empty(); });
    if (!has_empty) proposals.push_back(std::move(proposal));
  }
  std::ranges::stable_sort(proposals, std::ranges::greater(),
                           [](const Proposal& proposal) { return proposal.products.size(); });
  return proposals;
}

}  // namespace

std::span<const std::string_view> SplitRows::After() const {
  static constexpr std::array<std::string_view, 1> kAfter = {"merge.occluded_parts"};
  return kAfter;
}

Allowance SplitRows::MaxWork() const {
  return {.max_trials = kMaxTrials,
          .points_divisor = kPointsDivisor,
          .note = "it may be a row of objects: the cap of rows was reached"};
}

std::vector<Proposal> SplitRows::Propose(const SceneState& state,
                                         const RefinementContext& context) const {
  std::vector<Proposal> proposals;
  for (const HypothesisPtr& object : state.objects()) {
    context.work.Poll();
    const HypothesisModel& model = *object->model;
    const bool has_vessel = std::ranges::any_of(
        model.shapes(), [](const ShapePart& part) { return part.vessel != nullptr; });
    if (model.is_given || has_vessel || model.shapes().empty()) continue;
    for (Proposal& proposal : SplitsOf(state, *object)) proposals.push_back(std::move(proposal));
  }
  return proposals;
}

bool SplitRows::Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
                       const ObjectModel& found) const {
  if (!IsOneSolid(found, kMinExplained)) return false;
  const Pose X_GroundL =
      X_LGround(state.measured(), proposal.products[product].resting)->inverse(Eigen::Isometry);
  const ShapePart& solid = found.shapes.front();
  return TightBounds(solid.shape, X_GroundL * solid.X_OS).min().z() <= kMaxFootGap_m;
}

double SplitRows::Gain(const SceneState& state, const Proposal& proposal,
                       std::span<const ModelPtr> products) const {
  const ObjectHypothesis& before = state.Get(proposal.consumes.front().id);
  if (IsOneSolid(before.model->object, kOneSolid)) return SchwarzGain(state, proposal, products);
  return static_cast<double>(products.size() - 1);
}

}  // namespace cwm::perception
