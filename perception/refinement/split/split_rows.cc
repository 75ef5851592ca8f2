#include "perception/refinement/split/split_rows.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <optional>

#include "collision/geometry/aabb.h"
#include "perception/cloud/tolerances.h"
#include "perception/refinement/criterion.h"
#include "perception/refinement/evidence.h"
#include "perception/refinement/split/wall_profile.h"

namespace cwm::perception {
namespace {

// derived: the least length of the mean of unit vectors; for random directions it is less.
constexpr double kMinAgreement = kNormalMiss_sin;
// chosen: the penalty per seam, 3 ln 10 nats. Touching objects agree by chance in height, depth and
// direction with a probability of 1/10 each.
constexpr double kCoincidence = std::numbers::ln10 * 3;

// The points of an object in the frame of its ground, with z up.
struct Standing {
  std::vector<Vector3> p, n;
  std::vector<double> sigma_m;
  Vector2 middle = Vector2::Zero();

  bool IsWall(std::size_t k) const { return std::abs(n[k].z()) <= kWallRise_sin; }
};

Standing StandingPoints(const SceneState& state, const ObjectHypothesis& object,
                        const Pose& X_GroundL) {
  const OrientedPoints& all = state.points();
  Standing standing;
  for (const std::uint32_t i : object.points) {
    standing.p.push_back(X_GroundL * all.points[i].cast<double>());
    standing.n.push_back(X_GroundL.linear() * all.normals[i].cast<double>());
    standing.sigma_m.push_back(double{all.sigma_m[i]});
    standing.middle += standing.p.back().head<2>();
  }
  standing.middle /= static_cast<double>(object.points.size());
  return standing;
}

// The direction of upright faces at right angles: the mean of four times their angles.
std::optional<double> YawOfFaces(const Standing& standing) {
  std::complex<double> sum = 0;
  double count = 0;
  for (std::size_t k = 0; k < standing.p.size(); ++k) {
    if (!standing.IsWall(k)) continue;
    sum += std::polar(1.0, 4 * std::atan2(standing.n[k].y(), standing.n[k].x()));
    ++count;
  }
  if (!(std::abs(sum) > kMinAgreement * count)) return std::nullopt;
  return std::arg(sum) / 4;
}

// The direction of the greatest horizontal extent.
double YawOfExtent(const Standing& standing) {
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Vector3& p : standing.p) {
    const Vector2 d = p.head<2>() - standing.middle;
    spread += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spread);
  const Vector2 longest = solver.eigenvectors().col(1);
  return std::atan2(longest.y(), longest.x());
}

// The front of a row along `along`, seen from the direction `outward`.
std::vector<ProfilePoint> FrontOf(const Standing& standing, const Vector2& along,
                                  const Vector2& outward, double points_per_sample) {
  ProfileBuilder front(points_per_sample);
  for (std::size_t k = 0; k < standing.p.size(); ++k) {
    if (!standing.IsWall(k) || standing.n[k].head<2>().dot(outward) < kSteep_sin) continue;
    const Vector2 at = standing.p[k].head<2>();
    front.Add(along.dot(at), outward.dot(at), standing.sigma_m[k]);
  }
  return front.Profile();
}

// Seams between parts that are wide enough to show the slope of a wall.
std::vector<double> SeamsBetweenParts(const std::vector<ProfilePoint>& front) {
  std::vector<double> seams;
  if (front.empty()) return seams;
  double begin_m = front.front().along_m;
  for (const double seam_m : SeamsOf(front)) {
    const double end_m = front.back().along_m;
    if (std::min(seam_m - begin_m, end_m - seam_m) < kMinKinked_m) continue;
    seams.push_back(seam_m);
    begin_m = seam_m;
  }
  return seams;
}

// Objects that rest on the row rest on the part that is below them.
Proposal CutAt(const SceneState& state, const ObjectHypothesis& object, const Pose& X_GroundL,
               const Standing& standing, const Vector2& along, const std::vector<double>& seams) {
  const auto part_at = [&](const Vector3& p_Ground) {
    const auto seam = std::ranges::lower_bound(seams, along.dot(p_Ground.head<2>()));
    return static_cast<std::size_t>(seam - seams.begin());
  };
  std::vector<PointSet> parts(seams.size() + 1);
  for (std::size_t k = 0; k < standing.p.size(); ++k) {
    parts[part_at(standing.p[k])].push_back(object.points[k]);
  }
  Proposal proposal{.consumes = {{object.id}}};
  for (PointSet& part : parts) {
    Product product{.points = std::move(part),
                    .resting = object.resting,
                    .expects = Expectation::kSingleObject};
    product.node_count = NodesOf(object, product.points.size());
    proposal.products.push_back(std::move(product));
  }
  for (const HypothesisPtr& other : state.objects()) {
    if (other->resting.on != object.id) continue;
    Vector3 middle = Vector3::Zero();
    for (const std::uint32_t i : other->points) middle += state.points().points[i].cast<double>();
    middle /= std::max(1.0, static_cast<double>(other->points.size()));
    proposal.resting_updates.push_back({other->id, part_at(X_GroundL * middle), {}});
  }
  return proposal;
}

// One proposal for each direction of a row, the one with the most parts first.
std::vector<Proposal> CutsOf(const SceneState& state, const ObjectHypothesis& object) {
  const Pose X_GroundL = X_LGround(state.measured(), object.resting)->inverse(Eigen::Isometry);
  const Standing standing = StandingPoints(state, object, X_GroundL);
  const Vector2 eye = (X_GroundL * state.points().viewpoint).head<2>();
  std::vector<double> yaws_rad = {YawOfExtent(standing)};
  if (const std::optional<double> yaw_rad = YawOfFaces(standing)) {
    yaws_rad = {*yaw_rad, *yaw_rad + std::numbers::pi / 2};
  }
  std::vector<Proposal> proposals;
  for (const double yaw_rad : yaws_rad) {
    const Vector2 along(std::cos(yaw_rad), std::sin(yaw_rad));
    Vector2 outward(-along.y(), along.x());
    if (outward.dot(eye - standing.middle) < 0) outward = -outward;
    const std::vector<double> seams = SeamsBetweenParts(
        FrontOf(standing, along, outward, double{state.points().points_per_sample}));
    if (seams.empty()) continue;
    Proposal proposal = CutAt(state, object, X_GroundL, standing, along, seams);
    const bool has_empty = std::ranges::any_of(
        proposal.products, [](const Product& product) { return product.points.empty(); });
    if (!has_empty) proposals.push_back(std::move(proposal));
  }
  std::ranges::stable_sort(proposals, std::ranges::greater(),
                           [](const Proposal& proposal) { return proposal.products.size(); });
  return proposals;
}

// True for a single box or several solids, without vessels and not supplied by a pass. The minima
// rule does not hold along the wall of a single round solid.
bool MayBeRow(const HypothesisModel& model) {
  const std::vector<ShapePart>& shapes = model.shapes();
  const bool has_vessel =
      std::ranges::any_of(shapes, [](const ShapePart& part) { return part.vessel != nullptr; });
  if (model.is_given || has_vessel || shapes.empty()) return false;
  return shapes.size() > 1 || std::holds_alternative<Box>(shapes.front().shape);
}

class SplitRows : public RefinementPass {
 public:
  std::string_view Name() const override { return "split.rows"; }
  std::span<const std::string_view> After() const override {
    static constexpr std::array<std::string_view, 1> kAfter = {"merge.occluded_parts"};
    return kAfter;
  }
  TrialBudget MaxWork() const override {
    return {.max_trials = kMaxTrials,
            .note = "it may be a row of objects: the cap of rows was reached"};
  }

  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override {
    std::vector<Proposal> proposals;
    if (!state.sight()) return proposals;  // merged views have offsets, at which fronts jump
    for (const HypothesisPtr& object : state.objects()) {
      context.work.Poll();
      if (!MayBeRow(*object->model)) continue;
      for (Proposal& proposal : CutsOf(state, *object)) proposals.push_back(std::move(proposal));
    }
    return proposals;
  }

  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override {
    if (!IsSingleSolid(found)) return false;
    const Pose X_GroundL =
        X_LGround(state.measured(), proposal.products[product].resting)->inverse(Eigen::Isometry);
    const ShapePart& solid = found.shapes.front();
    return std::abs(TightBounds(solid.shape, X_GroundL * solid.X_OS).min().z()) <= kMaxContactGap_m;
  }

  // For an object of several solids, which only become separate objects, the number of seams. For a
  // single box, the gain of the criterion minus kCoincidence per seam.
  double Gain(const ModelledProposal& modelled) const override {
    const HypothesisId id = modelled.proposal.consumes.front().id;
    const auto seams = static_cast<double>(modelled.products.size() - 1);
    if (modelled.state.Get(id).model->shapes().size() > 1) return seams;
    return CriterionGain(modelled) - seams * kCoincidence;
  }
};

}  // namespace

std::unique_ptr<const RefinementPass> MakeSplitRows() {
  return std::make_unique<const SplitRows>();
}

}  // namespace cwm::perception
