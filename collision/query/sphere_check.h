// States of a robot, many at once in single precision: of one that is spheres alone all but what is
// too near to contact; of another, of one that carries objects, and where rules of pairs apply, by
// the spheres around its parts what these show to be free. What stays open is asked plainly.
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

// Refers to the rows. Used by one thread; a copy, which is cheap beside Make, is another's.
class SphereCheck {
 public:
  // Nothing where the question is another one: other shapes without spheres around them, too few
  // rows, rows that are no states of joints, FCL or Bullet asked for by name, joints that lanes do
  // not move, links that may get where worlds have no room, margins below zero, unseen space to be
  // reported, deviations, rules of pairs that set more than the request's margin.
  static std::optional<SphereCheck> Make(const WorldSnapshot& world, const QueryBody& body,
                                         const BodyRows& rows, const QueryOptions& options);

  // Of the rows [first, first + count): FREE, COLLISION and OUT_OF_LIMITS equal the plain verdicts;
  // UNDECIDED is to be asked plainly. The span holds until the next call.
  std::span<const Verdict> Judge(std::size_t first, std::size_t count);
  // By the same rows, what is to be asked about those that are UNDECIDED; empty: everything.
  std::span<const LaneOpen> open() const { return open_; }
  // Of the same rows, whether one that is UNDECIDED is known to be within limits.
  bool KnowsLimits(std::size_t k) const { return marks_[k] == StateMark::kReady; }
  // Of a row that is FREE, what is to be asked plainly about its trust: of what spheres show to be apart
  // they do not tell whether boxes about it meet those of an open mesh.
  const LaneOpen& open_of_trust() const { return open_of_trust_; }
  bool leaves_trust_open() const { return open_of_trust_.worlds != 0 || open_of_trust_.pairs != 0; }
  // Whether COLLISION is told at all: the spheres are the robot.
  bool tells_collisions() const { return meaning_ == Meaning::kTheBody; }

 private:
  enum class Meaning { kTheBody, kAroundTheBody };
  struct World {
    LaneScene scene;
    LaneOpen open_of_trust;
  };
  SphereCheck(const JointRows& rows, std::shared_ptr<const SphereProgram> program, World world,
              Meaning meaning);
  void JudgeLanes(std::size_t stride, std::size_t count, std::span<const std::uint32_t> order);

  const JointRows* rows_;
  Meaning meaning_;
  std::shared_ptr<const SphereProgram> program_;
  LaneScene scene_;
  LaneOpen open_of_trust_;
  bool base_is_within_limits_ = true;
  StateOrder order_;
  LaneMemory memory_;
  std::vector<float> values_, sorted_values_;
  std::vector<StateMark> marks_;
  std::vector<LaneVerdict> told_;
  std::vector<LaneOpen> found_, open_;
  std::vector<Verdict> verdicts_;
};

}  // namespace cwm::collision
