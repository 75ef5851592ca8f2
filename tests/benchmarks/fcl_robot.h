// The baseline for robots: FCL's own meshes and objects, queried as a planner's plain loop would.
#pragma once

#include <memory>
#include <span>

#include "collision/query/query.h"

namespace cwm::benchmarks {

// A body and a world held by FCL, made once per scene, outside of the timed part.
class FclRobot {
 public:
  // Takes box, sphere, cylinder and mesh parts; their bounds are FCL's.
  FclRobot(const collision::QueryBody& body, const collision::WorldSnapshot& world);
  ~FclRobot();

  // True if any part collides with an object or with its self pairs, in a loop over all pairs until
  // one collides.
  bool CollidesPlainly(std::span<const Pose> X_WF);
  // The same with FCL's tree of boxes over the world and boxes of the parts, as MoveIt does it.
  bool CollidesByTree(std::span<const Pose> X_WF);

  // Two parts of the body, or a part of the body and one of the world, numbered in the order of the
  // objects and of their parts. PairCollides takes them where the last query placed them, the
  // second part moved by an offset.
  struct Pair {
    std::size_t part = 0;
    std::size_t other = 0;
    bool is_self_pair = false;
  };
  bool PairCollides(const Pair& pair, const Vector3& offset_W) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cwm::benchmarks
