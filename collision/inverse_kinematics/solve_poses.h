// A batch of poses for a robot's tool, each solved for joint values and, on request, freed of
// collisions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/inverse_kinematics/ik_chain.h"
#include "collision/inverse_kinematics/pose_solver.h"
#include "collision/query/query.h"
#include "collision/query/robot_body.h"

namespace cwm::collision {

enum class PoseStatus : std::uint8_t {
  kSolved,
  kUnreachable,  // not reached from any start; not proven
  kOutOfLimits,  // only beyond the limits of joints
  kInCollision,  // every solution that was found collides, or is not known to be free
  kNotComputed
};

struct PoseBatch {
  std::span<const Pose> X_WT;  // the tool in the world
  Pose X_WB = Pose::Identity();
  // Rows of the group: one for all poses, or one for each.
  std::span<const double> seeds;
  double position_tolerance_m = 1e-6;
  double rotation_tolerance_rad = 1e-6;
  int max_solutions = 1;  // of each pose
  bool same_branch = false;
  bool avoid_collision = false;
  int max_steps = kIkSteps;
};

struct PoseColumns {
  std::vector<PoseStatus> status;
  // The rows of pose i are [row_begin[i], row_begin[i + 1]): its solutions, nearest to the seed
  // first. One row for a pose without a solution: the nearest that was found within the limits, for
  // kOutOfLimits beyond them, for kInCollision the solution nearest to the seed.
  std::vector<std::uint32_t> row_begin;
  std::vector<double> rows;                                  // of the group, one after the other
  std::vector<double> position_error_m, rotation_error_rad;  // by row
  std::size_t completed = 0;
};

// The pose of a tool that `body`, a robot of the snapshot, holds at the chain's end. `states` gives
// the group and the other variables; its rows are not read. Verdicts are those of CheckCollisions
// with the same options. The result has the same bytes on any number of threads; a deadline gives a
// prefix.
absl::StatusOr<PoseColumns> SolvePoses(const WorldSnapshot& world, const QueryBody& body,
                                       const IkChain& chain, const JointRows& states,
                                       const PoseBatch& batch, const QueryOptions& options,
                                       std::stop_token stop = {});

}  // namespace cwm::collision
