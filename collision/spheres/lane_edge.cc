#include <algorithm>
#include <cmath>
#include <numbers>

#include "collision/spheres/motion_lanes.h"

namespace cwm::collision {
namespace {

// derived: bounds are computed in double and rounded to float.
constexpr double kBoundsRoundedUp = 1.00001;

double NormOf(const float* v) { return std::hypot(double{v[0]}, double{v[1]}, double{v[2]}); }

}  // namespace

LaneEdgeMaker::LaneEdgeMaker(const SphereProgram& program, float gap_only_clearance_m)
    : program_(program) {
  edge_.gap_only_clearance_m = gap_only_clearance_m;
  const LaneProgram& lanes = program.lanes;
  below_speed_m_.resize(lanes.groups.size() * lanes.joints.size());
  below_bend_m_.resize(below_speed_m_.size());
  edge_.starts.resize(lanes.joints.size());
  edge_.rates.resize(lanes.joints.size());
  edge_.of_group.resize(lanes.groups.size());
  edge_.of_pair.resize(lanes.group_pairs.size());
}

const LaneEdge* LaneEdgeMaker::Make(std::span<const double> from, std::span<const double> step) {
  const LaneProgram& lanes = program_.lanes;
  const std::size_t frames = lanes.joints.size();
  double change = 0;
  for (std::size_t k = 1; k < frames; ++k) {
    const LaneInput& input = program_.inputs[k - 1];
    const double rate = input.multiplier * step[input.column];
    const double start = input.multiplier * from[input.column] + input.offset;
    if (!input.turns && std::abs(start) + std::abs(rate) > input.farthest) return nullptr;
    edge_.starts[k] = input.turns ? std::remainder(start, 2 * std::numbers::pi) : start;
    edge_.rates[k] = rate;
    change += std::abs(rate);
  }
  edge_.velocity_error_m = static_cast<float>(kBoundsRoundedUp * change * lanes.velocity_error);
  const auto bounds_of = [&](double speed_m, double bend_m) {
    return LaneEdge::Bounds{static_cast<float>(kBoundsRoundedUp * speed_m),
                            static_cast<float>(kBoundsRoundedUp * bend_m)};
  };
  for (std::size_t g = 0; g < lanes.groups.size(); ++g) {
    const LaneGroup& group = lanes.groups[g];
    double speed_m = 0, bend_m = 0;
    // The longest distance of a sphere from the origin of frame k.
    double lever_m = NormOf(group.bound.centre_m) + group.bound.radius_m;
    for (std::int32_t k = group.frame;; k = lanes.joints[static_cast<std::size_t>(k)].parent) {
      const auto at = static_cast<std::size_t>(k);
      below_speed_m_[g * frames + at] = speed_m;
      below_bend_m_[g * frames + at] = bend_m;
      if (k == 0) break;
      const LaneJoint& joint = lanes.joints[at];
      const double rate = std::abs(edge_.rates[at]);
      if (joint.turns) {
        bend_m += rate * (rate * lever_m + 2 * speed_m);
        speed_m += rate * lever_m;
      } else {
        speed_m += rate;
        lever_m += std::abs(edge_.starts[at]) + rate;
      }
      lever_m += NormOf(joint.shift_m);
    }
    edge_.of_group[g] = bounds_of(speed_m, bend_m);
  }
  for (std::size_t p = 0; p < lanes.group_pairs.size(); ++p) {
    const LaneGroupPair& pair = lanes.group_pairs[p];
    const auto at = [&](std::int32_t group) {
      return static_cast<std::size_t>(group) * frames + static_cast<std::size_t>(pair.ancestor);
    };
    const std::size_t a = at(pair.first), b = at(pair.second);
    edge_.of_pair[p] =
        bounds_of(below_speed_m_[a] + below_speed_m_[b], below_bend_m_[a] + below_bend_m_[b]);
  }
  return &edge_;
}

}  // namespace cwm::collision
