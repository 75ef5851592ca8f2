// A robot of spheres and what it may meet, as flat arrays of numbers: what many states are checked
// with at once. Everything lies in the frame of the robot's root, where coordinates are no greater
// than its reach. Plain numbers without Eigen, since the source that reads them is compiled for
// several instruction sets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cwm::collision {

inline constexpr int kTags = 64;  // bits of LaneOpen

// The joint that moves a frame: X_PF = (rotation, shift) * motion. The motion is the turn by the
// value about z or the shift by the value along z. Frame 0 is the root and has none.
struct LaneJoint {
  std::int32_t parent = 0;  // frame, less than the joint's own
  bool turns = true;
  float rotation[9] = {};  // row by row
  float shift_m[3] = {};
};

// What moves the frame of a joint: multiplier * row[column] + offset, angles taken to [-pi, pi].
struct LaneInput {
  std::size_t column = 0;
  double lower_limit = 0, upper_limit = 0;  // of row[column]; finite
  double multiplier = 1;
  double offset = 0;
  bool turns = true;
  // Within the limits nothing is beyond `farthest`, and no angle beyond [-pi, pi].
  bool stays_near = false;
  double lower = 0, upper = 0;  // of what moves the frame
  double lever_m = 0;           // the farthest that a sphere reaches from the joint
  double farthest =
      0;  // a greater value, either way, is beyond what the errors of centres are about
};

struct LaneSphere {
  float centre_m[3] = {};  // in the frame
  float radius_m = 0;
};

// A few spheres of one frame that lie near each other, with a sphere around them.
struct LaneCluster {
  std::int32_t frame = 0;
  std::int32_t first = 0, count = 0;  // into LaneProgram::spheres
  LaneSphere bound = {};
  float widest_m = 0;    // the greatest of the radii
  std::int32_t tag = 0;  // of LaneOpen::worlds
  // No centre, those of the bounds neither, is farther than this from where exact arithmetic has
  // it.
  float centre_error_m = 0;
};

// All clusters of one frame, with a sphere around them.
struct LaneGroup {
  std::int32_t frame = 0;
  std::int32_t first = 0, count = 0;  // into LaneProgram::clusters
  LaneSphere bound = {};
};

// How far from contact, as a squared distance minus a squared reach, single precision is sure.
struct LaneBand {
  float spheres_m2 = 0;
  float bounds_m2 = 0;
};

// Spheres `first` and `second` touch where the square of their centres' distance is `reach_m2`.
struct LaneSpherePair {
  std::int32_t first = 0, second = 0;
  float reach_m2 = 0;
};

// Two clusters, with the square of a reach that no pair of their spheres exceeds.
struct LaneClusterPair {
  std::int32_t first = 0, second = 0;  // clusters
  float reach_m2 = 0;
  std::int32_t begin = 0, end = 0;  // into LaneProgram::sphere_pairs; none: each with each
  std::int32_t tag = 0;             // of LaneOpen::pairs
  LaneBand band = {};
};

// Two groups, with the square of a reach that no pair of their spheres exceeds.
struct LaneGroupPair {
  std::int32_t first = 0, second = 0;  // groups
  float reach_m2 = 0;
  std::int32_t begin = 0, end = 0;  // into LaneProgram::cluster_pairs
  float bounds_m2 = 0;              // as LaneBand's
};

struct LaneProgram {
  std::vector<LaneJoint> joints;  // by frame; [0] is not read
  std::vector<LaneSphere> spheres;
  std::vector<LaneCluster> clusters;
  std::vector<LaneGroup> groups;
  std::vector<LaneGroupPair> group_pairs;
  std::vector<LaneClusterPair> cluster_pairs;
  std::vector<LaneSpherePair> sphere_pairs;
  float reach_m = 0;        // no centre is farther from the origin
  float pair_margin_m = 0;  // of clusters without a list of pairs
};

// A solid: `axis` are its axes as rows, a point is at axis * p - offset in its frame. Lanes spare
// themselves the product where the axes are those of the coordinates.
struct LaneObstacle {
  enum class Form : std::uint8_t {
    kRound,      // size: radius, half length along z
    kBox,        // size: half edges
    kCylinder,   // size: radius, half length
    kHalfSpace,  // solid for z <= 0
  };
  Form form = Form::kBox;
  // Only surrounds what is there: what it does not touch is free, what it touches is open.
  bool is_hull = false;
  bool is_aligned = false;  // axis is the identity
  float axis[9] = {};
  float offset_m[3] = {};
  float size_m[3] = {};
  float margin_m = 0;
};

// Obstacles in axes of their own: p_S = rotation * p_B of what is at p_B from the root.
struct LaneScene {
  float rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  // row by row
  std::vector<LaneObstacle> obstacles;
  // By group: the obstacles that it may reach, [begin, end) of `near`.
  struct Range {
    std::int32_t begin = 0, end = 0;
    LaneBand band;
  };
  std::vector<Range> near_group;
  std::vector<std::int32_t> near;
};

}  // namespace cwm::collision
