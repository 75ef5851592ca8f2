// Collision checks of many robot states at once by SIMD in single precision. For a robot made of
// spheres this decides all states that are not too near to contact. For other robots it proves
// states free by the spheres around the parts. Undecided states are left to the search pair by pair
// (BodySearch).
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collision/query/query.h"
#include "collision/query/robot_body.h"
#include "collision/query/sphere_query.h"
#include "collision/spheres/sphere_lanes.h"
#include "collision/spheres/state_order.h"

namespace cwm::collision {

// Refers to the rows. Used by one thread; other threads use copies, which are cheap compared to
// Make.
class SphereCheck {
 public:
  // Empty if CompileQuery does not suit the query, or rows are not joint states.
  static std::optional<SphereCheck> Make(const WorldSnapshot& world, const QueryBody& body,
                                         const BodyRows& rows, const QueryOptions& options);

  // The verdicts of rows [first, first + count): FREE, COLLISION and OUT_OF_LIMITS equal those of
  // the search pair by pair; UNDECIDED rows need that search. The span is valid until the next
  // call.
  std::span<const Verdict> Check(std::size_t first, std::size_t count);
  // The frames and pairs that remain to be tested in the k-th of these rows, which is UNDECIDED.
  UnresolvedTags open(std::size_t k) const { return open_[k]; }
  // True if the k-th of these rows is known to be within limits, even if it is UNDECIDED.
  bool IsKnownWithinLimits(std::size_t k) const { return marks_[k] == StateMark::kReady; }
  const UnresolvedTags& tags_for_accuracy() const { return query_->tags_for_accuracy; }
  bool needs_accuracy_tests() const {
    return tags_for_accuracy().worlds != 0 || tags_for_accuracy().pairs != 0;
  }
  // True if COLLISION can be returned for most rows that collide.
  bool decides_collisions() const { return query_->proves_contact; }

 private:
  SphereCheck(const JointRows& rows, SphereQuery query);
  void CheckLanes(std::size_t stride, std::size_t count, std::span<const std::uint32_t> order);

  const JointRows* rows_;
  std::shared_ptr<const SphereQuery> query_;
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
