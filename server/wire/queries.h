// Reads a query: the subject, the rows, the options.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/inverse_kinematics/solve_poses.h"
#include "collision/motion/check_paths.h"
#include "collision/query/query.h"
#include "cwm/v1/query.pb.h"
#include "cwm/v1/robot.pb.h"
#include "server/core/geometry_store.h"
#include "server/core/limits.h"
#include "server/core/world.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// Negative revisions of AtLeast and Exactly are refused.
absl::StatusOr<RevisionRule> RevisionRuleFromProto(const v1::AtRevision& rule,
                                                   const FieldPath& path);

// Precision of answer columns.
enum class Precision { kSingle, kDouble };
enum class Form { kColumns, kRows };

struct ParsedQueryOptions {
  RevisionRule at_revision;
  std::string world_uid;
  collision::QueryOptions query;  // give_up_at is set by the caller, who knows the deadline
  std::optional<std::chrono::nanoseconds> time_budget;
  Form form = Form::kColumns;
  Precision precision = Precision::kDouble;
};
// The number of contacts of a query: 0 means `otherwise`.
struct ContactCount {
  int otherwise = 16;
  int max = 1'024;
};
// The number of pairs of a world. A reply with the most of them has 10 MB.
inline constexpr ContactCount kWorldContactCount{.otherwise = 65'536, .max = 65'536};
absl::StatusOr<ParsedQueryOptions> QueryOptionsFromProto(const v1::QueryOptions& options,
                                                         const FieldPath& path,
                                                         const ContactCount& contacts = {});

// chosen: the most shapes of a body; each row checks every one of them.
inline constexpr int kMaxBodyShapes = 1'024;
// chosen: a robot that is a subject may have as many parts as an object of the world, and as many
// pairs of its own parts as a row checks in about 2 ms, during which it cannot be interrupted. (The
// Panda's 59 spheres have 690.)
inline constexpr std::int64_t kMaxRobotParts = 4'096;
inline constexpr std::int64_t kMaxSelfPairs = 1'000'000;
// derived: a point is queried as a ball of this radius, which is below the accuracy of answers
// (1e-7 m).
inline constexpr double kPointRadius_m = 1e-9;

// A robot in several states.
struct RobotRows {
  collision::WorldRobotPtr robot;
  const collision::JointGroup* group = nullptr;  // in the robot's model
  Pose X_WB = Pose::Identity();
  std::vector<double> base = {};  // a value for each variable of the model
  std::vector<double> rows = {};  // the group's variables, row by row
};

// The subject of a query and its rows: a rigid body at poses, or a robot in states.
struct StateQuery {
  collision::QueryBody body;
  std::variant<std::vector<Pose>, RobotRows> states;
};
// The rows in the form for queries and in the form for motions; both refer to the query.
std::unique_ptr<const collision::BodyRows> RowsOf(const StateQuery& query);
std::unique_ptr<const collision::Waypoints> WaypointsOf(const StateQuery& query);
// For a robot: the names of its body's parts and of its state's variables.
struct BodyNames {
  std::vector<std::string> links = {};    // for an attached object, the link that it is attached to
  std::vector<std::string> objects = {};  // "" for own parts; empty: nothing is attached
  std::vector<std::string> variables = {};
  std::vector<std::string> row_variables = {};  // those of a row, in its order
};
BodyNames BodyNamesOf(const StateQuery& query);

struct QuerySource {
  const collision::WorldSnapshot& snapshot;  // for subjects that are in the world
  const GeometryStore& store;
  const Limits& limits;
  std::span<const std::string> ignore = {};  // of the options: not attached to the robot, either
  WorkBudget* budget = nullptr;              // reading ends with its status
  std::span<const collision::NamedThing> only = {};  // of the options: restricts a robot's body
};
// NotFound OBJECT_UNKNOWN or ROBOT_UNKNOWN for a subject that is not in the snapshot.
absl::StatusOr<StateQuery> StateQueryFromProto(const v1::Subject& subject,
                                               const QuerySource& source, const FieldPath& path);
// FailedPrecondition NO_SPHERES if the given spheres are requested of a robot that was loaded
// without any.
absl::StatusOr<StateQuery> RobotQueryFromProto(const v1::RobotSubject& subject,
                                               const QuerySource& source, const FieldPath& path);

// Motions of a subject, each along a path.
struct MotionQuery {
  StateQuery query;
  std::vector<collision::Path> paths;
};
// Refuses points as subject.
absl::StatusOr<MotionQuery> MotionQueryFromProto(const v1::CheckMotionsRequest& request,
                                                 const QuerySource& source);

// Poses of a robot's tool, to be solved for states.
struct PoseQuery {
  StateQuery query;  // its rows are the seeds
  collision::IkChain chain = {};
  std::vector<Pose> X_WT = {};
  std::string tool_link = {};
  collision::PoseBatch batch = {};  // without what refers to the members above, see BatchOf
};
absl::StatusOr<PoseQuery> PoseQueryFromProto(const v1::SolvePosesRequest& request,
                                             const QuerySource& source);
// The batch with poses and seeds, which refer to the query, and the states for verdicts.
collision::PoseBatch BatchOf(const PoseQuery& query);
collision::JointRows JointRowsOf(const RobotRows& states);
// Sets the rows of `states`, whose other members are set: at most `max_rows`; without data the base
// is the one row. Refuses another width, values and quaternions that are no state, and rows that
// put a link out of range.
absl::Status ReadJointRows(const v1::JointRows& rows, std::int64_t max_rows, const FieldPath& path,
                           WorkBudget* budget, RobotRows& states);

// The links whose poses are asked for, by index; all of them, in the order of the URDF, if none is
// named.
absl::StatusOr<std::vector<int>> LinksFromProto(const v1::GetLinkPosesRequest& request,
                                                const StateQuery& query);

// Refuses RESULT_FORM_ROWS for more than limits.max_rows_as_messages rows.
absl::Status CheckForm(Form form, std::size_t row_count, const Limits& limits);

// Checks the largest possible number of answers of a batch against the limit of the form. `per_row`
// is the most answers per row, `field` the field of the request that sets it.
struct AnswerBound {
  std::string_view field;
  std::int64_t per_row;
  std::size_t row_count;
};
std::int64_t MaxAnswers(Form form, const Limits& limits);
absl::Status CheckAnswers(const AnswerBound& bound, Form form, const Limits& limits);

absl::Status UnknownObject(const std::string& name);

}  // namespace cwm::server
