// The reasons why FCL's verdict on a body of meshes in a world differs from the exact engine's.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "collision/query/query.h"
#include "tests/benchmarks/fcl_robot.h"

namespace cwm::benchmarks {

// Below any measurable distance: the surfaces are given in single precision, and FCL's own
// tolerances are 1e-6.
inline constexpr double kTouching_m = 1e-6;

// Ordered from the strongest proof to none.
enum class DifferenceCause {
  kContained,  // FCL's meshes are surfaces: one inside another collides with nothing
  kShared,     // FCL overlooks a point of a triangle that lies in the other solid
  kTouching,   // FCL's verdict changes after a move by no more than kTouching_m
  kUnknown,
};
std::string_view NameOf(DifferenceCause cause);

struct PlacedPart {
  const collision::PreparedPart& part;
  Pose X_WP;
};

// Keeps references to all of its arguments.
class DifferenceExplainer {
 public:
  DifferenceExplainer(const collision::QueryBody& body, const collision::WorldSnapshot& world,
                      const FclRobot& fcl);

  // The weakest reason among the pairs whose verdicts differ in a state, as `fcl` was last queried;
  // kUnknown if a pair has no reason or no pair differs.
  DifferenceCause Explain(std::span<const Pose> X_WF) const;

 private:
  PlacedPart Part(std::size_t k, std::span<const Pose> X_WF) const;
  PlacedPart Other(const FclRobot::Pair& pair, std::span<const Pose> X_WF) const;
  bool CollidesByExactEngine(const FclRobot::Pair& pair, std::span<const Pose> X_WF) const;
  std::vector<FclRobot::Pair> DifferingPairs(std::span<const Pose> X_WF) const;
  DifferenceCause CauseOf(const FclRobot::Pair& pair, std::span<const Pose> X_WF) const;

  const collision::QueryBody& body_;
  const FclRobot& fcl_;
  std::vector<PlacedPart> world_;
};

}  // namespace cwm::benchmarks
