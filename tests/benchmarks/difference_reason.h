// Why FCL tells another verdict of a body of meshes in a world than the exact engine.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "collision/query/query.h"
#include "tests/benchmarks/fcl_robot.h"

namespace cwm::benchmarks {

// What nobody can measure: the surfaces are given in single precision, FCL's own tolerances are
// 1e-6.
inline constexpr double kTouching_m = 1e-6;

// The stronger proof first.
enum class Why {
  kContained,  // FCL's meshes are surfaces: what one holds wholly collides with nothing
  kShared,     // FCL overlooks a point of a triangle that lies in the other solid
  kTouching,   // moved by no more than kTouching_m, FCL tells the other verdict
  kUnknown,
};
std::string_view NameOf(Why why);

struct PlacedPart {
  const collision::PreparedPart& part;
  Pose X_WP;
};

// Refers to all that it is given.
class DifferenceReason {
 public:
  DifferenceReason(const collision::QueryBody& body, const collision::WorldSnapshot& world,
                   const FclRobot& fcl);

  // Of a state in which the verdicts differ, as `fcl` was last asked: every pair of which they do
  // must be explained, and there must be one. The weakest proof of them.
  Why Explain(std::span<const Pose> X_WF) const;

 private:
  PlacedPart Part(std::size_t k, std::span<const Pose> X_WF) const;
  PlacedPart Other(const FclRobot::Pair& pair, std::span<const Pose> X_WF) const;
  bool Ours(const FclRobot::Pair& pair, std::span<const Pose> X_WF) const;
  std::vector<FclRobot::Pair> Different(std::span<const Pose> X_WF) const;
  Why WhyOf(const FclRobot::Pair& pair, std::span<const Pose> X_WF) const;

  const collision::QueryBody& body_;
  const FclRobot& fcl_;
  std::vector<PlacedPart> world_;
};

}  // namespace cwm::benchmarks
