// Certifies a motion of a robot of spheres, one interval of an edge per SIMD lane: that no sphere
// comes nearer than its margin at any time of the interval, or that one does at its middle.
//
// On an edge all joints change linearly. Let c(t) be the centre of a sphere, u the vector to c(m)
// from the nearest point of a convex obstacle at the middle m of an interval of half width h, and
// |c''| <= A on the whole edge. The plane through that nearest point perpendicular to u separates
// the two, hence at all times of the interval
//
//   distance >= |u| - h |u . c'(m)| / |u| - A h^2 / 2
//
// (Mirtich 1996 with the directional bound of Zhang, Lee and Kim 2006, to second order). For two
// spheres of the robot, u and c are those between their centres, in the frame above both. The bound
// A is that of a chain of joints whose values change by D_j in all, with L_j the longest distance
// of c from joint j: the sum over turning joints of |D_j| L_j (|D_j| + 2 sum of |D_k| over the
// turning joints k outside of j), and of 2 |D_j| |D_k| for sliding joints j.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/spheres/sphere_lanes.h"
#include "collision/spheres/sphere_program.h"

namespace cwm::collision {

// An edge as SIMD code reads it. Times are fractions of the edge.
struct LaneEdge {
  struct Bounds {
    float speed_m =
        0;  // of any sphere of the group, or of one of the pair in the frame of the other
    float bend_m = 0;  // of the second derivative
  };
  // By frame: the value of its joint at the start, less whole turns, and its change over the edge.
  std::vector<double> starts, rates;
  std::vector<Bounds> of_group;  // relative to the root
  std::vector<Bounds> of_pair;   // by group pair
  float velocity_error_m = 0;
  // Spheres that prove gaps only must keep clear by more than this; from 0 to kLaneClearance_m.
  float gap_only_clearance_m = 0;
};

// Fills an edge. `from` and `step` are the values of the program's columns at its start, and their
// change.
class LaneEdgeMaker {
 public:
  LaneEdgeMaker(const SphereProgram& program, float gap_only_clearance_m);
  // nullptr if a joint slides beyond the range for which the errors of centres hold.
  const LaneEdge* Make(std::span<const double> from, std::span<const double> step);

 private:
  const SphereProgram& program_;
  std::vector<double> below_speed_m_, below_bend_m_;  // by group and frame: of the joints below it
  LaneEdge edge_;
};

// chosen: fixed, so that the intervals into which an edge is divided do not depend on the machine.
inline constexpr std::size_t kIntervals = 8;

struct IntervalResult {
  bool is_contact = false;  // proven for the middle of the interval
  // What is not proven to keep clear for the whole interval, and what touches at its middle.
  UnresolvedTags open = {}, touching = {};
  // Some of it stays open however narrow the interval is: at its middle, spheres that prove gaps
  // only are too near.
  bool is_stuck = false;
  // No other pair comes nearer to its margin than this; at most kLaneClearance_m.
  float clearance_m = 0;

  bool is_free() const { return (open.worlds | open.pairs) == 0; }
};

// chosen: larger clearances are not measured.
inline constexpr float kLaneClearance_m = 0.02F;

struct Intervals {
  std::size_t count = 0;
  std::array<double, kIntervals> middle = {};
  std::array<float, kIntervals> half_width = {};  // rounded up
  // A pair is left open if less than this share of its gap at the middle is proven.
  std::array<float, kIntervals> least_share = {};
  UnresolvedTags needed;  // the others are known to keep clear
};

// Computes the results of the intervals, which are ordered by time. Those after the first in
// contact are undefined.
void CheckIntervals(const LaneProgram& program, const LaneScene& scene, const LaneEdge& edge,
                    const Intervals& intervals, LaneMemory& memory,
                    std::array<IntervalResult, kIntervals>& results);

}  // namespace cwm::collision
