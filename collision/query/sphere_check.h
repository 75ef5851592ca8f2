// Collision checks of many robot states at once by SIMD in single precision. For a robot made of
// spheres this decides all states that are not too near to contact. For other robots, with attached
// objects, or if pair rules apply, it proves states free by the spheres around the parts. Undecided
// states are left to the search pair by pair (BodySearch).
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collision/query/query.h"
#include "collision/query/robot_body.h"
#include "collision/query/world_filter.h"
#include "collision/spheres/sphere_lanes.h"
#include "collision/spheres/sphere_program.h"
#include "collision/spheres/state_order.h"

namespace cwm::collision {

// Refers to the rows. Used by one thread; other threads use copies, which are cheap compared to
// Make.
class SphereCheck {
 public:
  // Empty if the query is not suited: shapes without spheres around them, too few rows, rows that
  // are not joint states, FCL or Bullet chosen by name, joints that the SIMD kinematics do not
  // support, links that can leave the coordinates of a world, negative margins, unseen space to be
  // reported, margin_sigma > 0, pair rules with a larger margin than the request.
  static std::optional<SphereCheck> Make(const WorldSnapshot& world, const QueryBody& body,
                                         const BodyRows& rows, const QueryOptions& options);

  // The verdicts of rows [first, first + count): FREE, COLLISION and OUT_OF_LIMITS equal those of
  // the search pair by pair; UNDECIDED rows need that search. The span is valid until the next
  // call.
  std::span<const Verdict> Check(std::size_t first, std::size_t count);
  // The frames and pairs that remain to be tested in UNDECIDED rows, by row; everything if empty.
  std::span<const UnresolvedTags> open() const { return open_; }
  // True if the k-th of these rows is known to be within limits, even if it is UNDECIDED.
  bool IsKnownWithinLimits(std::size_t k) const { return marks_[k] == StateMark::kReady; }
  // The frames and pairs that determine the accuracy of a FREE row. Spheres prove parts apart, but
  // do not show if the boxes of parts meet those of an open mesh.
  const UnresolvedTags& tags_for_accuracy() const { return tags_for_accuracy_; }
  bool needs_accuracy_tests() const {
    return tags_for_accuracy_.worlds != 0 || tags_for_accuracy_.pairs != 0;
  }
  // True if COLLISION can be returned, that is if the spheres are the robot.
  bool decides_collisions() const { return role_ == SphereRole::kExact; }

 private:
  enum class SphereRole { kExact, kBounding };
  struct CompiledWorld {
    LaneScene scene;
    UnresolvedTags tags_for_accuracy;
  };
  SphereCheck(const JointRows& rows, std::shared_ptr<const SphereProgram> program,
              CompiledWorld world, SphereRole role);
  void CheckLanes(std::size_t stride, std::size_t count, std::span<const std::uint32_t> order);

  const JointRows* rows_;
  SphereRole role_;
  std::shared_ptr<const SphereProgram> program_;
  LaneScene scene_;
  UnresolvedTags tags_for_accuracy_;
  bool base_is_within_limits_ = true;
  StateOrder order_;
  LaneMemory memory_;
  std::vector<float> values_, sorted_values_;
  std::vector<StateMark> marks_;
  std::vector<LaneVerdict> lane_verdicts_;
  std::vector<UnresolvedTags> found_, open_;
  std::vector<Verdict> verdicts_;
};

}  // namespace cwm::collision
