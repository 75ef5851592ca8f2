// Certified edges of a robot by its spheres, many times of an edge at once
// (spheres/motion_lanes.h). Edges that single precision cannot decide are left to the search pair
// by pair.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "collision/motion/edge_search.h"
#include "collision/motion/open_times.h"
#include "collision/query/robot_body.h"
#include "collision/query/sphere_query.h"
#include "collision/spheres/motion_lanes.h"

namespace cwm::collision {

struct SphereMotionAnswer {
  // Where and when the edge is not proven free. Empty: it is free, or its first contact is known.
  OpenTimes open = {};
  // The first known contact: at `hi`, all that is not open being free before `lo`. Both are 0 if
  // the edge begins in contact. hi is beyond 1 if no contact is known.
  double lo = 1, hi = 2;
  UnresolvedTags tags = {};  // of what touches at `hi`, as in SphereQuery
  // Of what is not open, as in MotionColumns.
  double clearance_m = kMaxClearance_m;

  bool has_contact() const { return hi <= 1; }
};

// Refers to the rows. Used by one thread.
class SphereMotion {
 public:
  // Empty if CompileQuery does not suit the query, or unseen space is to be reported.
  static std::optional<SphereMotion> Make(const WorldSnapshot& world, const QueryBody& body,
                                          const JointRows& rows, const QueryOptions& options);

  // The edge from a row to the next.
  SphereMotionAnswer Check(std::size_t row);
  // Places the robot's links at a fraction of that edge.
  void Place(double fraction, std::span<Pose> X_WL);

 private:
  // An interval, and what is not proven to keep clear in it.
  struct Task {
    TimeSpan span = {};
    UnresolvedTags open = BodySearch::kAllUnresolved;
  };

  SphereMotion(const JointRows& rows, SphereQuery query);
  UnresolvedTags Divide(bool is_contact_known);
  void Evaluate(const UnresolvedTags& needed, bool is_contact_known);
  void Sort(SphereMotionAnswer& answer);

  const JointRows* rows_;
  std::shared_ptr<const SphereQuery> query_;
  LaneEdgeMaker edge_maker_;
  const double min_width_;       // narrower intervals are not divided
  std::vector<bool> is_cyclic_;  // by variable of the group
  // Of the edge at hand.
  std::vector<double> from_, step_;
  std::vector<double> state_;  // of all variables
  const LaneEdge* edge_ = nullptr;
  std::vector<Task> todo_;       // not proven so far, ordered by time
  std::vector<TimeSpan> batch_;  // parts of the first of todo_
  // Working memory.
  LaneMemory memory_;
  std::array<IntervalResult, kIntervals> results_ = {};
};

}  // namespace cwm::collision
