// Answers as columns. A matrix has one answer in each column (3 x A), a vector one answer in each
// entry. Points and normals are in the world's frame W; normals are unit vectors from the subject
// to the object.
//
// Answers are about the first completed_count rows of the query, which are all rows unless a time
// budget was spent.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "cwm/namespace.h"

namespace cwm::CWM_API {

enum class Verdict : std::uint8_t { kFree = 1, kCollision, kOutOfLimits, kUndecided, kNotComputed };
// kFree and kContact are certified.
enum class MotionVerdict : std::uint8_t {
  kFree = 1,
  kContact,
  kGrazing,
  kUndecided,
  kNotComputed,
  kOutOfLimits
};
// How far an answer can be believed: kBounded errs by at most bound_m, kSurfaceOnly is about open
// geometry without an inside, kDegraded has no known bound.
enum class Trust : std::uint8_t { kNone = 0, kExact, kBounded, kSurfaceOnly, kDegraded };
// kSmooth has the gradient of the distance, kKink one of several, kBeyond is farther than
// max_distance_m from everything.
enum class SampleState : std::uint8_t { kSmooth = 1, kKink, kBeyond };
// kUnreachable was not reached from any start, which proves nothing; kInCollision: no solution that
// was found is free.
enum class PoseStatus : std::uint8_t {
  kSolved = 1,
  kUnreachable,
  kOutOfLimits,
  kInCollision,
  kNotComputed
};

const char* NameOf(Verdict verdict);  // "COLLISION"
const char* NameOf(MotionVerdict verdict);
const char* NameOf(Trust trust);
const char* NameOf(SampleState state);
const char* NameOf(PoseStatus status);

// Special values of object_index.
inline constexpr int kNothing = -1;
inline constexpr int kItself = -2;  // the robot that is the subject

// An object or a robot in an answer. Answers refer to it by an index.
struct AnsweredObject {
  std::string name;
  std::string uid;                           // empty for an object of an overlay
  std::vector<std::string> part_links = {};  // of a robot, the link of each of its parts
};

// The members that all answers share.
struct ResultHead {
  std::string world_uid = {};
  std::int64_t revision = 0;
  Eigen::Index row_count = 0;                // asked
  Eigen::Index completed_count = 0;          // answered
  std::vector<AnsweredObject> objects = {};  // ordered by name

  bool complete() const { return completed_count == row_count; }
};

// Which pair an answer is about.
struct PairColumns {
  Eigen::VectorXi object_index = {};  // into `objects`, or kNothing, or kItself
  Eigen::VectorXi body_part = {};     // of the subject
  Eigen::VectorXi object_part = {};   // of the object; with kItself, of the subject
  std::string robot = {};             // the robot that is the subject, if it is one
  // If the subject is a robot, for each part of its body the link, and the object that the link
  // carries, "" for the robot's own parts; body_objects is empty if it carries nothing.
  std::vector<std::string> body_links = {};
  std::vector<std::string> body_objects = {};
};

// A pair in words.
struct NamedPairOfParts {
  std::string body_link = {};    // of the subject, if it is a robot
  std::string body_object = {};  // what the robot carries there, if it is that
  std::string object = {};       // "" if none is named; for kItself the robot's own name
  std::string object_link = {};  // if `object` is a robot
};

struct CheckResult : ResultHead, PairColumns {
  std::vector<Verdict> verdict = {};  // the pair has a meaning for kCollision and kUndecided
  std::vector<Trust> trust = {};
  std::vector<std::string> variables = {};  // of the robot; empty if no row is kOutOfLimits
  Eigen::VectorXi variable_index = {};      // the first out of its limits; -1: none

  bool free(Eigen::Index row) const;
  bool all_free() const;  // all rows that were asked about
  NamedPairOfParts pair(Eigen::Index row) const;
};

// A answers to N rows, those of row i from row_begin[i] to row_begin[i + 1].
struct PairResult : ResultHead, PairColumns {
  std::vector<Eigen::Index> row_begin = {0};
  Eigen::VectorXd distance_m = {};   // < 0: the depth of penetration; without margins
  Eigen::Matrix3Xd point_body = {};  // nearest, or deepest, points
  Eigen::Matrix3Xd point_object = {};
  Eigen::Matrix3Xd normal = {};
  std::vector<Trust> trust = {};
  Eigen::VectorXd bound_m = {};  // of kBounded and kSurfaceOnly; 0 for kExact, NaN for kDegraded
  // With QueryOptions::joint_gradient, dof x A: the derivative of distance_m by each variable,
  // m/rad or m/m, and whether it is one of several, since other points are as near.
  std::vector<std::string> variables = {};
  Eigen::MatrixXd joint_gradient = {};
  std::vector<bool> gradient_kink = {};

  Eigen::Index size() const { return distance_m.size(); }
  NamedPairOfParts pair(Eigen::Index answer) const;
  // (N): the least distance of each row; NaN where there is none.
  Eigen::VectorXd nearest_m() const;
};

// One entry per motion.
struct MotionResult : ResultHead, PairColumns {
  std::vector<MotionVerdict> verdict = {};
  // From the motion's row `segment` to the next; -1 if it is free or not computed.
  Eigen::VectorXi segment = {};
  Eigen::VectorXd lo = {};  // share of the segment: nothing is met before
  Eigen::VectorXd hi = {};  // share of the segment: the pair is in contact there
  // Of a free motion: the least distance of any pair above its margin, up to 0.02.
  Eigen::VectorXd clearance_m = {};
  std::vector<Trust> trust = {};
  std::vector<std::string> variables = {};  // as in CheckResult, for the row `segment`
  Eigen::VectorXi variable_index = {};

  bool free(Eigen::Index motion) const;
  bool all_free() const;  // all motions that were asked about
  NamedPairOfParts pair(Eigen::Index motion) const;
};

// One entry per ray; the other columns have a meaning where `hit`.
struct RayResult : ResultHead {
  std::vector<bool> hit = {};
  Eigen::VectorXd distance_m = {};
  Eigen::Matrix3Xd normal = {};  // outward
  Eigen::VectorXi object_index = {};
  Eigen::VectorXi object_part = {};
  std::vector<Trust> trust = {};

  std::string object(Eigen::Index ray) const;  // its name, "" if nothing is hit
};

// One entry per point; the other columns have a meaning where the state is not kBeyond.
struct SampleResult : ResultHead {
  std::vector<SampleState> state = {};
  Eigen::VectorXd distance_m = {};  // < 0: inside
  Eigen::Matrix3Xd gradient = {};   // unit: d distance / d point
  Eigen::VectorXi object_index = {};
  Eigen::VectorXi object_part = {};
  std::vector<Trust> trust = {};
  Eigen::VectorXd bound_m = {};  // by how much a kBounded point may be deeper; 0 for others

  std::string object(Eigen::Index point) const;  // its name, "" if nothing is near enough
};

// All pairs of parts of a world that are nearer than their margin, deepest first. The member a has
// the lower object index, or for a pair of one robot the lower part.
struct WorldContacts {
  std::string world_uid = {};
  std::int64_t revision = 0;
  bool is_complete = true;  // false: the time budget or max_contacts ended the list
  std::vector<AnsweredObject> objects = {};
  Eigen::VectorXi object_a = {};
  Eigen::VectorXi object_b = {};
  Eigen::VectorXi part_a = {};
  Eigen::VectorXi part_b = {};
  Eigen::VectorXd distance_m = {};
  Eigen::Matrix3Xd point_a = {};
  Eigen::Matrix3Xd point_b = {};
  Eigen::Matrix3Xd normal = {};  // from a to b
  std::vector<Trust> trust = {};
  Eigen::VectorXd bound_m = {};

  Eigen::Index size() const { return distance_m.size(); }
};

// States of a robot for poses of its tool. Those of pose i are the columns from row_begin[i] to
// row_begin[i + 1]: its solutions, nearest to the seed first; of a pose without one, the single
// state that shows how far it could be met.
struct PoseResult {
  std::string world_uid = {};
  std::int64_t revision = 0;
  Eigen::Index row_count = 0;
  Eigen::Index completed_count = 0;
  std::vector<PoseStatus> status = {};
  std::vector<Eigen::Index> row_begin = {0};
  std::vector<std::string> variables = {};
  Eigen::MatrixXd states = {};  // dof x M, rad or m, in the order of `variables`
  Eigen::VectorXd position_error_m = {};
  Eigen::VectorXd rotation_error_rad = {};
  std::string tool_link = {};

  bool complete() const { return completed_count == row_count; }
  bool solved(Eigen::Index pose) const;
  // dof x K; none if the pose is not solved.
  Eigen::MatrixXd solutions(Eigen::Index pose) const;
};

// The poses of links in states of a robot.
struct LinkPoses {
  std::string world_uid = {};
  std::int64_t revision = 0;
  Eigen::Index row_count = 0;
  Eigen::Index completed_count = 0;
  std::vector<std::string> links = {};
  std::vector<Eigen::Isometry3d> X_WL = {};  // row by row, in the order of `links`

  bool complete() const { return completed_count == row_count; }
  // Throws Error with kNotFound for a link that was not asked for.
  const Eigen::Isometry3d& pose(Eigen::Index row, const std::string& link) const;
};

}  // namespace cwm::CWM_API
