// A robot of spheres compiled for lanes: what its group moves, and nothing else.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "collision/robot/robot_model.h"
#include "collision/spheres/lane_program.h"

namespace cwm::collision {

struct PlacedSphere {
  int link = 0;
  Vector3 centre_L = Vector3::Zero();
  double radius_m = 0;
};

// Two spheres of different links that must not touch, by their places in the list.
struct SpherePair {
  std::int32_t first = 0;
  std::int32_t second = 0;
};

// What moves the frame of a joint of the lanes: multiplier * row[column] + offset.
struct JointInput {
  std::size_t column = 0;
  double multiplier = 1;
  double offset = 0;
  bool turns = true;
  double farthest = 0;  // a greater value, either way, is beyond what `centre_error_m` is about
};

struct SphereProgram {
  LaneProgram lanes;
  std::vector<JointInput> inputs;  // by frame of `lanes`, from frame 1 on
  // By cluster: a ball, in the frame of the root, that it cannot leave.
  struct Ball {
    Vector3 centre = Vector3::Zero();
    double radius_m = 0;
  };
  std::vector<Ball> reach_of_cluster;
};

// `base` has a value for each variable of the model; those of the group are not read. A pair is
// apart by `pair_margin_m` or more. Nothing where a planar or a floating joint moves.
std::optional<SphereProgram> CompileSpheres(const RobotModel& model, const JointGroup& group,
                                            std::span<const double> base,
                                            std::span<const PlacedSphere> spheres,
                                            std::span<const SpherePair> pairs,
                                            double pair_margin_m);

// Values of rows, as JudgeStates takes them: angles go to [-pi, pi], in double precision. False for a
// value that lanes cannot take.
bool ToLanes(const SphereProgram& program, std::span<const double> row, float* values,
             std::size_t stride);

// Half a unit in the last place of 1.
inline constexpr double kFloatRounding = 5.9604644775390625e-8;

// What to leave undecided, as a squared distance beyond a squared reach, where distances are off by
// no more than `error_m`: (reach + error)^2 - reach^2 and the rounding of the squares.
double Undecided_m2(double error_m, double widest_reach_m);

}  // namespace cwm::collision
