// States of a robot that is spheres alone, many at once in single precision: what is too near to
// contact to be told so stays open and is asked plainly.
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

// Refers to the rows. One per call, used by one thread.
class SphereCheck {
 public:
  // Nothing where the question is another one: other shapes, rows that are no states of joints, FCL or
  // Bullet asked for by name, joints that lanes do not move, margins below zero.
  static std::optional<SphereCheck> Make(const WorldSnapshot& world, const QueryBody& body,
                                         const BodyRows& rows, const QueryOptions& options);

  // Of the rows [first, first + count): FREE, COLLISION and OUT_OF_LIMITS equal the plain verdicts;
  // UNDECIDED is to be asked plainly. The span holds until the next call.
  std::span<const Verdict> Judge(std::size_t first, std::size_t count);

 private:
  SphereCheck(const JointRows& rows, SphereProgram program, LaneScene scene);

  const JointRows* rows_;
  SphereProgram program_;
  LaneScene scene_;
  bool base_is_within_limits_ = true;
  StateOrder order_;
  LaneMemory memory_;
  std::vector<float> values_, sorted_values_;
  std::vector<StateMark> marks_;
  std::vector<LaneVerdict> told_;
  std::vector<Verdict> verdicts_;
};

}  // namespace cwm::collision
