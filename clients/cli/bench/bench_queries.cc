#include "clients/cli/bench/bench_queries.h"

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
void SetCommon(const QueriedWorld& world, Request& request) {
  request.set_world(world.name);
  request.mutable_options()->set_result_form(pb::RESULT_FORM_COLUMNS);
  request.mutable_options()->set_scalar(pb::SCALAR_F64);
}

pb::Subject GripperAtRandomPoses(const QueriedWorld& world, int rows) {
  pb::Subject subject;
  pb::Subject::Shapes& shapes = *subject.mutable_shapes();
  pb::Box& box = *shapes.add_shapes()->mutable_box();
  box.set_size_x_m(0.10);
  box.set_size_y_m(0.08);
  box.set_size_z_m(0.20);
  Random random(kPosesSeed);
  std::vector<client::PoseRow> poses;
  for (int i = 0; i < rows; ++i) poses.push_back(random.RandomPose(world.region));
  shapes.mutable_x_world_body()->set_scalar(pb::SCALAR_F64);
  shapes.mutable_x_world_body()->set_data(client::RowBytes(poses));
  return subject;
}

double RandomValue(const pb::RobotVariable& variable, Random& random) {
  const double reach =
      variable.joint_kind() == pb::JOINT_KIND_PRISMATIC ? 1.0 : std::numbers::pi;  // m, rad
  return random.Uniform(variable.has_lower() ? variable.lower() : -reach,
                        variable.has_upper() ? variable.upper() : reach);
}

absl::Status CheckRowCount(std::int64_t completed, const BenchQuery& query) {
  if (completed == query.rows) return absl::OkStatus();
  return absl::InternalError(
      absl::StrCat(query.name, ": ", completed, " of ", query.rows, " rows were answered"));
}

template <class Response, class Method, class Request>
absl::Status CallOnce(const client::Connection& connection, Method method, const Request& request,
                      const BenchQuery& query) {
  const absl::StatusOr<Response> answer = connection.Call(method, connection.queries(), request);
  return answer.ok() ? CheckRowCount(answer->completed_count(), query) : answer.status();
}

std::int64_t CompletedCount(const pb::StreamQueriesResponse& response) {
  if (response.has_check_collisions()) return response.check_collisions().completed_count();
  if (response.has_get_distances()) return response.get_distances().completed_count();
  if (response.has_sample_points()) return response.sample_points().completed_count();
  return 0;
}

}  // namespace

BenchQuery BodyChecks(const QueriedWorld& world, int rows) {
  BenchQuery query{.name = "body checks", .rows = rows, .request = {}};
  pb::CheckCollisionsRequest& request = *query.request.mutable_check_collisions();
  SetCommon(world, request);
  *request.mutable_subject() = GripperAtRandomPoses(world, rows);
  return query;
}

BenchQuery Distances(const QueriedWorld& world, int rows) {
  BenchQuery query{.name = "distances", .rows = rows, .request = {}};
  pb::GetDistancesRequest& request = *query.request.mutable_get_distances();
  SetCommon(world, request);
  *request.mutable_subject() = GripperAtRandomPoses(world, rows);
  return query;
}

BenchQuery SampledPoints(const QueriedWorld& world, int rows) {
  BenchQuery query{.name = "sample points", .rows = rows, .request = {}};
  pb::SamplePointsRequest& request = *query.request.mutable_sample_points();
  SetCommon(world, request);
  Random random(kPointsSeed);
  std::vector<client::PointRow> points;
  for (int i = 0; i < rows; ++i) points.push_back(random.RandomPoint(world.region));
  request.mutable_points()->set_scalar(pb::SCALAR_F64);
  request.mutable_points()->set_data(client::RowBytes(points));
  return query;
}

BenchQuery RobotStates(const QueriedWorld& world, const pb::Robot& robot, int rows) {
  BenchQuery query{.name = "robot states", .rows = rows, .request = {}};
  pb::CheckCollisionsRequest& request = *query.request.mutable_check_collisions();
  SetCommon(world, request);
  pb::RobotSubject& subject = *request.mutable_subject()->mutable_robot();
  subject.set_robot(robot.name());
  Random random(kStatesSeed);
  std::vector<std::array<double, 1>> numbers;
  for (int i = 0; i < rows; ++i) {
    for (int k = 0; k < robot.variables_size(); ++k) {
      // Floating joints stay in place: their variables cannot be drawn independently.
      const bool floats = robot.variables(k).joint_kind() == pb::JOINT_KIND_FLOATING;
      numbers.push_back({floats ? robot.state(k) : RandomValue(robot.variables(k), random)});
    }
  }
  subject.mutable_rows()->set_scalar(pb::SCALAR_F64);
  subject.mutable_rows()->set_width(robot.variables_size());
  subject.mutable_rows()->set_data(client::RowBytes(numbers));
  return query;
}

BenchQuery InEmptySpace(const QueriedWorld& world,
                        const std::function<BenchQuery(const QueriedWorld&)>& make_query) {
  QueriedWorld above = world;
  above.region.min[2] += kFarAbove_m;
  above.region.max[2] += kFarAbove_m;
  BenchQuery query = make_query(above);
  pb::StreamQueriesRequest& request = query.request;
  if (request.has_check_collisions()) {
    pb::Subject& subject = *request.mutable_check_collisions()->mutable_subject();
    if (!subject.has_robot()) return query;
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
  return query;
}

absl::Status CallUnary(const client::Connection& connection, const BenchQuery& query) {
  using Stub = pb::QueryService::Stub;
  const pb::StreamQueriesRequest& request = query.request;
  if (request.has_check_collisions()) {
    return CallOnce<pb::CheckCollisionsResponse>(connection, &Stub::CheckCollisions,
                                                 request.check_collisions(), query);
  }
  if (request.has_get_distances()) {
    return CallOnce<pb::GetDistancesResponse>(connection, &Stub::GetDistances,
                                              request.get_distances(), query);
  }
  return CallOnce<pb::SamplePointsResponse>(connection, &Stub::SamplePoints,
                                            request.sample_points(), query);
}

absl::Status CallStream(client::QueryStream& stream, BenchQuery& query) {
  const auto answer = stream.Evaluate(query.request);
  return answer.ok() ? CheckRowCount(CompletedCount(*answer), query) : answer.status();
}

}  // namespace cwm::cli
