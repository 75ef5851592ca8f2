// A robot of spheres compiled for lanes: what its group moves, and nothing else.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "collision/robot/robot_model.h"
#include "collision/spheres/lane_program.h"

namespace cwm::collision {

// Fixed to a link: a frame of its own beside those of the links.
struct HungFrame {
  int link = 0;
  Pose X_LF = Pose::Identity();
};

struct PlacedSphere {
  int link = 0;  // of the model; beyond its links the k-th hung frame
  Vector3 centre_L = Vector3::Zero();
  double radius_m = 0;
};

// Two spheres of different links that must not touch, by their places in the list.
struct SpherePair {
  std::int32_t first = 0;
  std::int32_t second = 0;
};

// What must not touch: these spheres, and each with each of these links. A cluster's tag is its
// link, that of a pair of clusters the place of the links in the list, both modulo kTags.
struct TouchingPairs {
  std::span<const SpherePair> spheres = {};
  std::span<const LinkPair> links = {};
};

struct SphereProgram {
  LaneProgram lanes;
  std::vector<LaneInput> inputs;  // by frame of `lanes`, from frame 1 on
  // By group: a ball, in the frame of the root, that it cannot leave.
  struct Ball {
    Vector3 centre = Vector3::Zero();
    double radius_m = 0;
  };
  std::vector<Ball> reach_of_group;
};

// What lanes move, and what of it must not touch.
struct SphereSet {
  std::span<const PlacedSphere> spheres;
  std::span<const HungFrame> hung = {};
  TouchingPairs pairs = {};  // hung frames are links too
};

// A rail without limits: lanes take no state that slides a frame farther.
inline constexpr double kFarthestShift_m = 100;

// `base` has a value for each variable of the model; those of the group are not read. A pair is
// apart by `pair_margin_m` or more; pairs that are so at every state within the limits are left
// out, where that is found in some microseconds. Nothing where a planar or a floating joint moves.
std::optional<SphereProgram> CompileSpheres(const RobotModel& model, const JointGroup& group,
                                            std::span<const double> base, const SphereSet& set,
                                            double pair_margin_m);

// Half a unit in the last place of 1.
inline constexpr double kFloatRounding = 5.9604644775390625e-8;

// By how much a distance may be off that lanes find from coordinates no greater than these.
// Products and sums between the coordinates of a centre and its distance (sphere_lanes.cc) are each
// a rounding of numbers no greater than the coordinates: 14 at most for a cylinder's two ways
// together, doubled. And a slack for axes that are taken for level ones and for the plain path in
// double precision.
double Rounding_m(double coordinate_m);

// Where distances are off by no more than `error_m`: (reach + error)^2 - reach^2 and the rounding
// of the squares, for the greatest reach of two spheres that are compared, and of two bounds.
LaneBand BandOf(double error_m, double widest_sphere_m, double widest_bound_m);

}  // namespace cwm::collision
