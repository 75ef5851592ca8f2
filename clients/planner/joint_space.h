// The joints of a plan as an OMPL state space.
#pragma once

#include <ompl/base/spaces/RealVectorStateSpace.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cwm::planner {

// The joints' values, in rad or m.
using Row = std::vector<double>;

struct Joint {
  enum class Kind { kLimited, kContinuous };
  std::string name;
  Kind kind = Kind::kLimited;
  // For limited joints, lower <= upper. A continuous joint has no limits and is sampled within a
  // turn.
  double lower = 0, upper = 0;
};

// Rows of numbers, one per joint. Between two rows a limited joint moves linearly and a continuous
// one the short way, as on the server. The distance is Euclidean, with radians and metres weighted
// equally, so no joint moves by more than the distance.
class JointSpace : public ompl::base::RealVectorStateSpace {
 public:
  // `seed` is used by the samplers of the space: the first one samples the same rows in every
  // process.
  JointSpace(std::vector<Joint> joints, std::uint32_t seed);

  const std::vector<Joint>& joints() const { return joints_; }
  std::size_t width() const { return joints_.size(); }

  // The first joint that is out of its limits; empty if all are within.
  std::optional<std::size_t> OutOfLimits(std::span<const double> row) const;

  double Distance(std::span<const double> a, std::span<const double> b) const;
  // The row at the share t of the way from a to b; `out` may alias a or b.
  void Interpolate(std::span<const double> a, std::span<const double> b, double t,
                   std::span<double> out) const;

  double distance(const ompl::base::State* a, const ompl::base::State* b) const override;
  void interpolate(const ompl::base::State* from, const ompl::base::State* to, double t,
                   ompl::base::State* out) const override;
  void enforceBounds(ompl::base::State* state) const override;
  bool satisfiesBounds(const ompl::base::State* state) const override;
  double getMaximumExtent() const override;

  std::span<const double> RowOf(const ompl::base::State* state) const {
    return {state->as<StateType>()->values, width()};
  }
  std::span<double> RowOf(ompl::base::State* state) const {
    return {state->as<StateType>()->values, width()};
  }

 private:
  // The signed difference from a to b; for a continuous joint at most half a turn.
  double Difference(std::size_t joint, double a, double b) const;

  std::vector<Joint> joints_;
};

}  // namespace cwm::planner
