// What a batch asks: the body or points, the rows, the options.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/motion/check_paths.h"
#include "collision/query/query.h"
#include "cwm/v1/query.pb.h"
#include "server/core/geometry_store.h"
#include "server/core/limits.h"
#include "server/core/world.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// AtLeast and Exactly must not be negative.
absl::StatusOr<RevisionRule> FromProto(const v1::AtRevision& rule, const FieldPath& path);

// Precision of answer columns.
enum class Precision { kSingle, kDouble };
enum class Form { kColumns, kRows };

struct QuestionOptions {
  RevisionRule at_revision;
  std::string world_uid;
  collision::QueryOptions query;  // give_up_at is left to the caller, who knows the deadline
  std::optional<std::chrono::nanoseconds> time_budget;
  Form form = Form::kColumns;
  Precision precision = Precision::kDouble;
};
absl::StatusOr<QuestionOptions> FromProto(const v1::QueryOptions& options, const FieldPath& path);

// Shapes of a body, at most kMaxBodyShapes: each row asks about every one of them.
inline constexpr int kMaxBodyShapes = 1'024;
// A robot that asks may have as many parts as an object of the world, and as many pairs of its own
// parts as a row looks at in some 2 ms, which nothing interrupts. (The Panda's 59 spheres: 690.)
inline constexpr std::int64_t kMaxRobotParts = 4'096;
inline constexpr std::int64_t kMaxSelfPairs = 1'000'000;
// A point is asked about as a ball of this radius: below what an answer may be off (1e-7 m).
inline constexpr double kPointRadius_m = 1e-9;

// States of a robot.
struct RobotStates {
  collision::WorldRobotPtr robot;
  const collision::JointGroup* group = nullptr;  // of the robot's model
  Pose X_WB = Pose::Identity();
  std::vector<double> base = {};  // a value for each variable of the model
  std::vector<double> rows = {};  // the group's variables, row by row
};

// What asks, and where it is: a rigid body at poses, or a robot in states.
struct Question {
  collision::QueryBody body;
  std::variant<std::vector<Pose>, RobotStates> where;
};
// The rows as questions take them, and as motions do; both refer to the question.
std::unique_ptr<const collision::BodyRows> RowsOf(const Question& question);
std::unique_ptr<const collision::Waypoints> WaypointsOf(const Question& question);
// Of a robot that asks what each part of its body and each number of its state is.
struct BodyNames {
  std::vector<std::string> links = {};    // of an object that it carries the one that carries it
  std::vector<std::string> objects = {};  // empty where a part is the robot's own, or all are
  std::vector<std::string> variables = {};
};
BodyNames BodyNamesOf(const Question& question);

struct QuestionSource {
  const collision::WorldSnapshot& snapshot;  // for a subject that is of the world
  const GeometryStore& store;
  const Limits& limits;
  std::span<const std::string> ignore = {};  // of the options: a robot does not carry it either
  WorkBudget* budget = nullptr;              // reading ends with its status
};
// NotFound OBJECT_UNKNOWN or ROBOT_UNKNOWN for a subject that is not in the snapshot.
absl::StatusOr<Question> FromProto(const v1::Subject& subject, const QuestionSource& source,
                                   const FieldPath& path);
// FailedPrecondition NO_SPHERES for spheres as given of a robot that was loaded without.
absl::StatusOr<Question> FromProto(const v1::RobotSubject& subject, const QuestionSource& source,
                                   const FieldPath& path);

// Motions of a subject, each along a path.
struct MotionQuestion {
  Question question;
  std::vector<collision::Path> paths;
};
// Refuses subjects of points.
absl::StatusOr<MotionQuestion> FromProto(const v1::CheckMotionsRequest& request,
                                         const QuestionSource& source);

// RESULT_FORM_ROWS is for at most limits.max_rows_as_messages rows.
absl::Status CheckForm(Form form, std::size_t row_count, const Limits& limits);

// The most that the batch may answer, `per_row` a row, against the limits of the form. `field` is
// the option that says `per_row`.
struct AnswerBound {
  std::string_view field;
  std::int64_t per_row;
  std::size_t row_count;
};
absl::Status CheckAnswers(const AnswerBound& bound, Form form, const Limits& limits);

absl::Status UnknownObject(const std::string& name);

}  // namespace cwm::server
