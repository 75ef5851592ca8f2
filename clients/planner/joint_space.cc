#include "clients/planner/joint_space.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace cwm::planner {
namespace {

namespace ob = ompl::base;

constexpr double kTurn_rad = 2 * std::numbers::pi;

// A uniform sampler with its own seed; OMPL seeds samplers by the number made before in the
// process.
class SeededSampler : public ob::RealVectorStateSampler {
 public:
  SeededSampler(const ob::StateSpace* space, std::uint32_t seed)
      : ob::RealVectorStateSampler(space) {
    rng_.setLocalSeed(seed);
  }
};

}  // namespace

JointSpace::JointSpace(std::vector<Joint> joints, std::uint32_t seed)
    : ob::RealVectorStateSpace(static_cast<unsigned int>(joints.size())),
      joints_(std::move(joints)) {
  ob::RealVectorBounds bounds(static_cast<unsigned int>(width()));
  for (std::size_t j = 0; j < width(); ++j) {
    const bool turns = joints_[j].kind == Joint::Kind::kContinuous;
    bounds.low[j] = turns ? -kTurn_rad / 2 : joints_[j].lower;
    bounds.high[j] = turns ? kTurn_rad / 2 : joints_[j].upper;
  }
  // setBounds would refuse a joint whose limits are equal, which is valid here.
  bounds_ = bounds;
  setStateSamplerAllocator(
      [seed](const ob::StateSpace* space) { return std::make_shared<SeededSampler>(space, seed); });
}

std::optional<std::size_t> JointSpace::OutOfLimits(std::span<const double> row) const {
  for (std::size_t j = 0; j < width(); ++j) {
    if (joints_[j].kind == Joint::Kind::kContinuous) continue;
    if (row[j] < joints_[j].lower || row[j] > joints_[j].upper) return j;
  }
  return std::nullopt;
}

double JointSpace::Difference(std::size_t joint, double a, double b) const {
  const double difference = b - a;
  if (joints_[joint].kind == Joint::Kind::kLimited) return difference;
  return std::remainder(difference, kTurn_rad);
}

double JointSpace::Distance(std::span<const double> a, std::span<const double> b) const {
  double sum = 0;
  for (std::size_t j = 0; j < width(); ++j) {
    const double difference = Difference(j, a[j], b[j]);
    sum += difference * difference;
  }
  return std::sqrt(sum);
}

void JointSpace::Interpolate(std::span<const double> a, std::span<const double> b, double t,
                             std::span<double> out) const {
  if (t >= 1) {  // a + difference could exceed the limit by rounding
    std::copy(b.begin(), b.end(), out.begin());
    return;
  }
  for (std::size_t j = 0; j < width(); ++j) out[j] = a[j] + t * Difference(j, a[j], b[j]);
}

double JointSpace::distance(const ob::State* a, const ob::State* b) const {
  return Distance(RowOf(a), RowOf(b));
}

void JointSpace::interpolate(const ob::State* from, const ob::State* to, double t,
                             ob::State* out) const {
  Interpolate(RowOf(from), RowOf(to), t, RowOf(out));
}

void JointSpace::enforceBounds(ob::State* state) const {
  const std::span<double> row = RowOf(state);
  for (std::size_t j = 0; j < width(); ++j) {
    row[j] = joints_[j].kind == Joint::Kind::kContinuous
                 ? std::remainder(row[j], kTurn_rad)
                 : std::clamp(row[j], joints_[j].lower, joints_[j].upper);
  }
}

bool JointSpace::satisfiesBounds(const ob::State* state) const {
  return !OutOfLimits(RowOf(state)).has_value();
}

double JointSpace::getMaximumExtent() const {
  double sum = 0;
  for (const Joint& joint : joints_) {
    const double extent =
        joint.kind == Joint::Kind::kContinuous ? kTurn_rad / 2 : joint.upper - joint.lower;
    sum += extent * extent;
  }
  return std::sqrt(sum);
}

}  // namespace cwm::planner
