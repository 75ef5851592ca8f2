// A robot of spheres compiled for SIMD code, for the variables of one group.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "collision/robot/robot_model.h"
#include "collision/spheres/lane_program.h"

namespace cwm::collision {

// An additional frame that is fixed to a link.
struct FixedFrame {
  int link = 0;
  Pose X_LF = Pose::Identity();
};

struct PlacedSphere {
  int link = 0;  // of the model; from its number of links on, the k-th fixed frame
  Vector3 centre_L = Vector3::Zero();
  double radius_m = 0;
  LaneProof proof = {};
  // Spheres of one link have the same number; links of different numbers share no group, so that
  // obstacles can be left out for one of them or have another margin.
  int scene_class = 0;
  friend bool operator==(const PlacedSphere&, const PlacedSphere&) = default;
};

// Two spheres of different links that must stay `margin_m` apart, by index. The tag is that of
// their clusters in UnresolvedTags::pairs; pairs of the same two links have the same one.
struct SpherePair {
  std::int32_t first = 0;
  std::int32_t second = 0;
  std::int32_t tag = 0;
  double margin_m = 0;
  friend bool operator==(const SpherePair&, const SpherePair&) = default;
};

// Two links whose spheres must all stay `margin_m` apart.
struct SphereLinkPair {
  LinkPair links;
  std::int32_t tag = 0;  // as in SpherePair
  // A margin below the one that is asked, as of an object that may reach into its support: a gap is
  // proven, contact is not.
  bool proves_gap_only = false;
  double margin_m = 0;
  friend bool operator==(const SphereLinkPair&, const SphereLinkPair&) = default;
};

// The pairs that must not touch: single pairs of spheres, and all pairs of spheres of two links.
// The tag of a cluster is the index of its link modulo kTags.
struct CheckedPairs {
  std::span<const SpherePair> spheres = {};
  std::span<const SphereLinkPair> links = {};
};

struct SphereProgram {
  LaneProgram lanes;
  std::vector<LaneInput> inputs;    // by frame of `lanes`, from frame 1 on
  std::vector<int> class_of_group;  // PlacedSphere::scene_class
  // By group: a ball, in the frame of the root, that the group cannot leave.
  struct Ball {
    Vector3 centre = Vector3::Zero();
    double radius_m = 0;
  };
  std::vector<Ball> reach_of_group;
};

// The spheres that move, and the pairs of them that must not touch.
struct SphereSet {
  std::span<const PlacedSphere> spheres;
  std::span<const FixedFrame> fixed_frames = {};
  CheckedPairs pairs = {};  // fixed frames count as links
};

// chosen: SIMD code takes no state that slides a frame farther, which matters for rails without
// limits.
inline constexpr double kMaxSlide_m = 100;

// Compiles the spheres. `base` has a value for each variable of the model; those of the group are
// not read. Pairs that stay apart in all states within the limits are left out if this can be
// proven within some microseconds. Empty if a planar or floating joint of the group moves a link.
std::optional<SphereProgram> CompileSpheres(const RobotModel& model, const JointGroup& group,
                                            std::span<const double> base, const SphereSet& set);

// derived: half a unit in the last place of 1.
inline constexpr double kFloatRounding = 5.9604644775390625e-8;

// A bound on the error of distances that SIMD code computes from coordinates up to `coordinate_m`.
// derived: each product and sum between the coordinates of a centre and its distance
// (sphere_lanes.cc) rounds numbers no larger than the coordinates. There are at most 14 for a
// cylinder, whose two directions add up; this is doubled and rounded up. A slack covers axes that
// are treated as aligned, and the scalar path in double precision.
double Rounding_m(double coordinate_m);

// The bands for distances with errors up to `error_m`: (reach + error)^2 - reach^2 plus the
// rounding of the squares, for the largest reach of two spheres, and of two bounds.
LaneBand BandOf(double error_m, double max_sphere_radius_m, double max_bound_radius_m);

}  // namespace cwm::collision
