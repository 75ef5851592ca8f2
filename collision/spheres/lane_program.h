// A robot of spheres and its obstacles as flat arrays of numbers, against which many states are
// checked at once. Everything is in the frame of the robot's root, in which coordinates are bounded
// by its reach. Plain numbers without Eigen, because the source that reads them is compiled for
// several instruction sets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cwm::collision {

inline constexpr int kTags = 64;  // number of bits in each member of UnresolvedTags

// The joint that moves a frame: X_PF = (rotation, shift) * motion, where the motion is the rotation
// by the value about z or the translation by the value along z. Frame 0 is the root and has no
// joint.
struct LaneJoint {
  std::int32_t parent = 0;  // frame, less than the joint's own index
  bool turns = true;
  float rotation[9] = {};  // row-major
  float shift_m[3] = {};
  double exact_rotation[9] = {}, exact_shift_m[3] = {};
};

// Computes the value of a joint from a row: multiplier * row[column] + offset, with angles reduced
// to [-pi, pi].
struct LaneInput {
  std::size_t column = 0;
  double lower_limit = 0, upper_limit = 0;  // of row[column]; finite
  double multiplier = 1;
  double offset = 0;
  bool turns = true;
  // True if no value within the limits is beyond `farthest`, and no angle beyond [-pi, pi].
  bool stays_near = false;
  double lower = 0, upper = 0;  // of the joint's value
  double lever_m = 0;           // the largest distance of a sphere from the joint
  double farthest = 0;  // larger magnitudes exceed the range for which the errors of centres hold
};

struct LaneSphere {
  float centre_m[3] = {};  // in the frame
  float radius_m = 0;
};

// What spheres can prove of the solid that they stand for: a gap if they contain it, contact if
// they lie in it, both if they are it.
struct LaneProof {
  bool of_gap = true, of_contact = true;

  // The proofs that are left against a solid that only contains an obstacle.
  LaneProof With(bool is_hull) const { return {of_gap, of_contact && !is_hull}; }
  friend LaneProof operator&(const LaneProof& a, const LaneProof& b) {
    return {a.of_gap && b.of_gap, a.of_contact && b.of_contact};
  }
  friend bool operator==(const LaneProof&, const LaneProof&) = default;
};

// A few spheres of one frame that are near each other, with a sphere around them.
struct LaneCluster {
  std::int32_t frame = 0;
  std::int32_t first = 0, count = 0;  // into LaneProgram::spheres
  LaneSphere bound = {};
  float max_radius_m = 0;  // the largest radius
  std::int32_t tag = 0;    // of UnresolvedTags::worlds
  LaneProof proof = {};
  // Bounds on the deviation of all centres, including those of bounds, from the exact positions,
  // and the same where frames are placed in double precision.
  float centre_error_m = 0, motion_error_m = 0;
};

// All clusters of one frame, with a sphere around them.
struct LaneGroup {
  std::int32_t frame = 0;
  std::int32_t first = 0, count = 0;  // into LaneProgram::clusters
  LaneSphere bound = {};
  std::uint64_t tags = 0;  // bits of the tags of its clusters
};

// The margin around contact, as a squared distance minus a squared reach, within which single
// precision cannot decide.
struct LaneBand {
  float spheres_m2 = 0;
  float bounds_m2 = 0;
  // A bound on the error of the distances themselves, where frames are placed in double precision
  // (motion_lanes.h).
  float motion_error_m = 0;
};

// Spheres `first` and `second` touch if the squared distance of their centres is `reach_m2`.
struct LaneSpherePair {
  std::int32_t first = 0, second = 0;
  float reach_m2 = 0;
};

// Two clusters, with a squared reach that no pair of their spheres exceeds.
struct LaneClusterPair {
  std::int32_t first = 0, second = 0;  // clusters
  float reach_m2 = 0;
  std::int32_t begin = 0, end = 0;  // into LaneProgram::sphere_pairs; empty: all pairs of spheres
  std::int32_t tag = 0;             // of UnresolvedTags::pairs
  LaneBand band = {};
  LaneProof proof = {};
  float margin_m = 0;  // for pairs without a list, whose reach is the sum of radii and this
};

// Two groups, with a squared reach that no pair of their spheres exceeds.
struct LaneGroupPair {
  std::int32_t first = 0, second = 0;  // groups
  float reach_m = 0, reach_m2 = 0;
  std::int32_t begin = 0, end = 0;  // into LaneProgram::cluster_pairs
  LaneBand band = {};               // of bounds only
  std::int32_t ancestor = 0;        // the frame above both whose joints move them alike
  std::uint64_t tags = 0;           // bits of the tags of its pairs of clusters
};

struct LaneProgram {
  std::vector<LaneJoint> joints;  // by frame; [0] is not used
  std::vector<LaneSphere> spheres;
  std::vector<LaneCluster> clusters;
  std::vector<LaneGroup> groups;
  std::vector<LaneGroupPair> group_pairs;
  std::vector<LaneClusterPair> cluster_pairs;
  std::vector<LaneSpherePair> sphere_pairs;
  // A bound on the error of a point's velocity, if the values of all joints change by one in sum.
  float velocity_error = 0;
  float reach_m = 0;  // no centre is farther from the origin
};

// A solid. The rows of `axis` are its axes: a point p is at axis * p - offset in its frame. The
// product is skipped if the axes are those of the coordinates.
struct LaneObstacle {
  enum class Form : std::uint8_t {
    kRound,      // size: radius, half length along z
    kBox,        // size: half edges
    kCylinder,   // size: radius, half length
    kHalfSpace,  // solid for z <= 0
  };
  Form form = Form::kBox;
  // True if the solid only contains the object: spheres clear of it are free, spheres that touch it
  // are open.
  bool is_hull = false;
  bool is_aligned = false;  // axis is the identity
  float axis[9] = {};
  float offset_m[3] = {};
  float size_m[3] = {};
  float margin_m = 0;
};

// Obstacles in a rotated root frame S: p_S = rotation * p_B for a point p_B in the root's frame.
struct LaneScene {
  float rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major
  std::vector<LaneObstacle> obstacles;
  // By group: the obstacles that the group can reach, as a range [begin, end) of `near`.
  struct Range {
    std::int32_t begin = 0, end = 0;
    LaneBand band;
  };
  std::vector<Range> near_group;
  std::vector<std::int32_t> near;
};

}  // namespace cwm::collision
