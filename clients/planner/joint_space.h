// The joints that a plan moves, as a state space of OMPL.
#pragma once

#include <ompl/base/spaces/RealVectorStateSpace.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cwm::planner {

// A joint's values, rad or m.
using Row = std::vector<double>;

struct Joint {
  enum class Kind { kLimited, kContinuous };
  std::string name;
  Kind kind = Kind::kLimited;
  // Of a limited joint, lower <= upper; a continuous one goes round and is sampled within a turn.
  double lower = 0, upper = 0;
};

// Rows of numbers, one a joint. Between two rows a limited joint moves linearly and a continuous
// one the short way, as the server moves a robot. The distance is that of Euclid, radians and
// metres counted alike: no joint moves by more than it.
class JointSpace : public ompl::base::RealVectorStateSpace {
 public:
  // The seed is of the samplers that the space makes: the first one made samples the same rows in
  // every process.
  JointSpace(std::vector<Joint> joints, std::uint32_t seed);

  const std::vector<Joint>& joints() const { return joints_; }
  std::size_t width() const { return joints_.size(); }

  // The joint that is outside of its limits; nothing: all are within.
  std::optional<std::size_t> OutOfLimits(std::span<const double> row) const;

  double Distance(std::span<const double> a, std::span<const double> b) const;
  // The row at the share t of the way from a to b; `out` may be a or b.
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
  // From a to b: of a continuous joint, half a turn at most.
  double Difference(std::size_t joint, double a, double b) const;

  std::vector<Joint> joints_;
};

}  // namespace cwm::planner
