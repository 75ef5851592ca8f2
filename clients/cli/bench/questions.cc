#include "clients/cli/bench/questions.h"

#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cpp/row_bytes.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

// Each kind of query has its own random places.
constexpr std::uint64_t kPosesSeed = 7;
constexpr std::uint64_t kPointsSeed = 8;
constexpr std::uint64_t kStatesSeed = 9;

// chosen: higher than any world.
constexpr double kFarAbove_m = 1000;

// Sets the common fields of all requests.
template <class Request>
void SetCommon(const AskedWorld& world, Request& request) {
  request.set_world(world.name);
  request.mutable_options()->set_result_form(pb::RESULT_FORM_COLUMNS);
  request.mutable_options()->set_scalar(pb::SCALAR_F64);
}

pb::Subject GripperAtPlaces(const AskedWorld& world, int rows) {
  pb::Subject subject;
  pb::Subject::Shapes& shapes = *subject.mutable_shapes();
  pb::Box& box = *shapes.add_shapes()->mutable_box();
  box.set_size_x_m(0.10);
  box.set_size_y_m(0.08);
  box.set_size_z_m(0.20);
  Random random(kPosesSeed);
  std::vector<client::PoseRow> poses;
  for (int i = 0; i < rows; ++i) poses.push_back(random.PoseIn(world.region));
  shapes.mutable_x_world_body()->set_scalar(pb::SCALAR_F64);
  shapes.mutable_x_world_body()->set_data(client::RowBytes(poses));
  return subject;
}

double StateBetween(const pb::RobotVariable& variable, Random& random) {
  const double reach =
      variable.joint_kind() == pb::JOINT_KIND_PRISMATIC ? 1.0 : std::numbers::pi;  // m, rad
  return random.Between(variable.has_lower() ? variable.lower() : -reach,
                        variable.has_upper() ? variable.upper() : reach);
}

absl::Status CheckComplete(std::int64_t completed, const Question& question) {
  if (completed == question.rows) return absl::OkStatus();
  return absl::InternalError(
      absl::StrCat(question.of, ": ", completed, " of ", question.rows, " rows were answered"));
}

template <class Response, class Method, class Request>
absl::Status CallOnce(const client::Connection& connection, Method method, const Request& request,
                      const Question& question) {
  const absl::StatusOr<Response> answer = connection.Call(method, connection.queries(), request);
  return answer.ok() ? CheckComplete(answer->completed_count(), question) : answer.status();
}

std::int64_t CompletedCount(const pb::StreamQueriesResponse& response) {
  if (response.has_check_collisions()) return response.check_collisions().completed_count();
  if (response.has_get_distances()) return response.get_distances().completed_count();
  if (response.has_sample_points()) return response.sample_points().completed_count();
  return 0;
}

}  // namespace

Question BodyChecks(const AskedWorld& world, int rows) {
  Question question{.of = "body checks", .rows = rows, .request = {}};
  pb::CheckCollisionsRequest& request = *question.request.mutable_check_collisions();
  SetCommon(world, request);
  *request.mutable_subject() = GripperAtPlaces(world, rows);
  return question;
}

Question Distances(const AskedWorld& world, int rows) {
  Question question{.of = "distances", .rows = rows, .request = {}};
  pb::GetDistancesRequest& request = *question.request.mutable_get_distances();
  SetCommon(world, request);
  *request.mutable_subject() = GripperAtPlaces(world, rows);
  return question;
}

Question SampledPoints(const AskedWorld& world, int rows) {
  Question question{.of = "sample points", .rows = rows, .request = {}};
  pb::SamplePointsRequest& request = *question.request.mutable_sample_points();
  SetCommon(world, request);
  Random random(kPointsSeed);
  std::vector<client::PointRow> points;
  for (int i = 0; i < rows; ++i) points.push_back(random.PointIn(world.region));
  request.mutable_points()->set_scalar(pb::SCALAR_F64);
  request.mutable_points()->set_data(client::RowBytes(points));
  return question;
}

Question RobotStates(const AskedWorld& world, const pb::Robot& robot, int rows) {
  Question question{.of = "robot states", .rows = rows, .request = {}};
  pb::CheckCollisionsRequest& request = *question.request.mutable_check_collisions();
  SetCommon(world, request);
  pb::RobotSubject& subject = *request.mutable_subject()->mutable_robot();
  subject.set_robot(robot.name());
  Random random(kStatesSeed);
  std::vector<std::array<double, 1>> numbers;
  for (int i = 0; i < rows; ++i) {
    for (int k = 0; k < robot.variables_size(); ++k) {
      // Floating joints stay in place: their variables cannot be drawn independently.
      const bool floats = robot.variables(k).joint_kind() == pb::JOINT_KIND_FLOATING;
      numbers.push_back({floats ? robot.state(k) : StateBetween(robot.variables(k), random)});
    }
  }
  subject.mutable_rows()->set_scalar(pb::SCALAR_F64);
  subject.mutable_rows()->set_width(robot.variables_size());
  subject.mutable_rows()->set_data(client::RowBytes(numbers));
  return question;
}

Question OfNothing(const AskedWorld& world, const std::function<Question(const AskedWorld&)>& ask) {
  AskedWorld above = world;
  above.region.least[2] += kFarAbove_m;
  above.region.most[2] += kFarAbove_m;
  Question question = ask(above);
  pb::StreamQueriesRequest& request = question.request;
  if (request.has_check_collisions()) {
    pb::Subject& subject = *request.mutable_check_collisions()->mutable_subject();
    if (!subject.has_robot()) return question;
    subject.mutable_robot()->set_scope(pb::ROBOT_SCOPE_WORLD);
    pb::Pose& base = *subject.mutable_robot()->mutable_x_world_base();
    base.set_tz_m(kFarAbove_m);
    base.set_qw(1);
  }
  // Ends the search for the nearest object at once, since nothing is near enough.
  if (request.has_get_distances()) {
    request.mutable_get_distances()->mutable_options()->set_max_distance_m(0);
  }
  if (request.has_sample_points()) {
    request.mutable_sample_points()->mutable_options()->set_max_distance_m(0);
  }
  return question;
}

absl::Status AskUnary(const client::Connection& connection, const Question& question) {
  using Stub = pb::QueryService::Stub;
  const pb::StreamQueriesRequest& request = question.request;
  if (request.has_check_collisions()) {
    return CallOnce<pb::CheckCollisionsResponse>(connection, &Stub::CheckCollisions,
                                                 request.check_collisions(), question);
  }
  if (request.has_get_distances()) {
    return CallOnce<pb::GetDistancesResponse>(connection, &Stub::GetDistances,
                                              request.get_distances(), question);
  }
  return CallOnce<pb::SamplePointsResponse>(connection, &Stub::SamplePoints,
                                            request.sample_points(), question);
}

absl::Status AskStream(client::QueryStream& stream, Question& question) {
  const auto answer = stream.Ask(question.request);
  return answer.ok() ? CheckComplete(CompletedCount(*answer), question) : answer.status();
}

}  // namespace cwm::cli
