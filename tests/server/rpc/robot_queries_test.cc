// Queries about robots and motions, over a real socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "collision/motion/check_paths.h"
#include "collision/query/robot_body.h"
#include "tests/collision/robot/robot_text.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using collision::testing::Ball;
using collision::testing::JointText;
using collision::testing::Links;
using collision::testing::Robot;
using collision::testing::ThreeBalls;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kSrdf[] =
    "<robot name=\"r\"><group name=\"arm\"><joint name=\"shoulder\"/><joint "
    "name=\"elbow\"/></group>"
    "<group_state name=\"side\" group=\"arm\"><joint name=\"shoulder\" "
    "value=\"1.5\"/></group_state>"
    "</robot>";

template <class Number>
std::string Bytes(const std::vector<Number>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number));
}

// The arm "r" of three balls at the origin, and a box with edges of 0.2 m at (1, 0, 0), which
// contains the hand if both joints are at 0.
class RobotQueries : public RunningServer {
 protected:
  using RunningServer::RunningServer;

  void SetUp() override {
    Load("r", true);
    PutBox("post", 1);
  }
  void Load(const std::string& name, bool with_spheres) {
    v1::LoadRobotHeader header;
    header.set_urdf(Robot(ThreeBalls()));
    header.set_srdf(kSrdf);
    if (with_spheres) header.set_spheres(Robot(ThreeBalls()));
    LoadRobot(name, header);
  }
  static v1::Subject Arm(const std::vector<double>& rows) {
    v1::Subject subject;
    subject.mutable_robot()->set_robot("r");
    subject.mutable_robot()->set_group("arm");
    subject.mutable_robot()->mutable_rows()->set_data(Bytes(rows));
    return subject;
  }
  static std::vector<double> RandomRows(std::size_t count) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> angle(-3.05, 3.05);  // some are beyond the limits
    std::vector<double> rows;
    for (std::size_t k = 0; k < 2 * count; ++k) rows.push_back(angle(random));
    return rows;
  }

  template <class Request, class Response>
  using Method = grpc::Status (v1::QueryService::Stub::*)(grpc::ClientContext*, const Request&,
                                                          Response*);
  template <class Request, class Response>
  Response MustAnswer(Method<Request, Response> method, const Request& request) {
    Call call;
    Response response;
    const grpc::Status status = ((*query_).*method)(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }
  v1::CheckCollisionsResponse Check(const v1::CheckCollisionsRequest& request) {
    return MustAnswer(&v1::QueryService::Stub::CheckCollisions, request);
  }
  v1::CheckMotionsResponse Move(const v1::CheckMotionsRequest& request) {
    return MustAnswer(&v1::QueryService::Stub::CheckMotions, request);
  }
  grpc::Status Refused(const v1::CheckCollisionsRequest& request) {
    Call call;
    v1::CheckCollisionsResponse ignored;
    return query_->CheckCollisions(&call, request, &ignored);
  }
  grpc::Status Refused(const v1::CheckMotionsRequest& request) {
    Call call;
    v1::CheckMotionsResponse ignored;
    return query_->CheckMotions(&call, request, &ignored);
  }
  SnapshotPtr Snapshot() { return (*application_.worlds.Find("", ""))->Snapshot(); }
};

TEST_F(RobotQueries, MeetTheWorldThemselvesAndTheirLimits) {
  v1::CheckCollisionsRequest request;
  *request.mutable_subject() = Arm({0, 0, 1, 0, 1, 3, 1, 3.1});
  request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  const v1::CheckCollisionsResponse response = Check(request);
  EXPECT_THAT(response.body_links(), ElementsAre("a", "c", "e"));
  ASSERT_EQ(response.rows_size(), 4);
  EXPECT_EQ(response.rows(0).verdict(), v1::VERDICT_COLLISION);
  EXPECT_EQ(response.rows(0).object(), "post");
  EXPECT_EQ(response.rows(0).body_link(), "e");
  EXPECT_EQ(response.rows(1).verdict(), v1::VERDICT_FREE);
  EXPECT_EQ(response.rows(1).trust(), v1::TRUST_EXACT);
  EXPECT_FALSE(response.rows(1).has_body_link());
  EXPECT_EQ(response.rows(2).verdict(), v1::VERDICT_COLLISION);
  EXPECT_FALSE(response.rows(2).has_object());
  EXPECT_EQ(response.rows(2).body_link(), "a");
  EXPECT_EQ(response.rows(2).object_link(), "e");
  EXPECT_EQ(response.rows(3).verdict(), v1::VERDICT_OUT_OF_LIMITS);
}

TEST_F(RobotQueries, AnswerAsTheCoreDoesByteForByte) {
  constexpr std::size_t kRows = 500;
  const std::vector<double> rows = RandomRows(kRows);
  const SnapshotPtr world = Snapshot();
  const collision::WorldRobotPtr robot = world->FindRobot("r");
  const collision::JointRows states(robot->model(), *robot->model().FindGroup("arm"),
                                    {.base = robot->state, .rows = rows});
  const auto body = collision::BodyFromRobot(*robot, collision::RobotScope::kBoth);
  v1::CheckCollisionsRequest check;
  *check.mutable_subject() = Arm(rows);
  const v1::CheckCollisionsResponse checked = Check(check);
  const auto verdicts = *collision::CheckCollisions(*world, body, states, {});
  EXPECT_EQ(checked.object_index(), Bytes(verdicts.object));
  EXPECT_EQ(checked.body_part(), Bytes(verdicts.body_part));
  EXPECT_EQ(checked.object_part(), Bytes(verdicts.object_part));
  ASSERT_EQ(checked.verdicts().size(), kRows);
  for (std::size_t k = 0; k < kRows; ++k) {
    const bool collides = verdicts.verdict[k] == collision::Verdict::kCollision;
    EXPECT_EQ(checked.verdicts()[k] == v1::VERDICT_COLLISION, collides) << k;
  }
  for (const char some : {v1::VERDICT_FREE, v1::VERDICT_COLLISION, v1::VERDICT_OUT_OF_LIMITS}) {
    EXPECT_THAT(checked.verdicts(), ::testing::Contains(some));
  }
  v1::GetDistancesRequest distances;
  *distances.mutable_subject() = Arm(rows);
  distances.mutable_options()->set_max_results(2);
  const v1::PairColumns near =
      MustAnswer(&v1::QueryService::Stub::GetDistances, distances).columns();
  const auto nearest = *collision::GetDistances(*world, body, states, {.max_results = 2});
  EXPECT_EQ(near.distance_m(), Bytes(nearest.distance_m));
  EXPECT_EQ(near.point_body(), Bytes(nearest.point_body));
  EXPECT_EQ(near.normal(), Bytes(nearest.normal));
  EXPECT_EQ(near.object_index(), Bytes(nearest.object));
  v1::GetContactsRequest contacts;
  *contacts.mutable_subject() = Arm(rows);
  const v1::PairColumns touching =
      MustAnswer(&v1::QueryService::Stub::GetContacts, contacts).columns();
  const auto touched = *collision::GetContacts(*world, body, states, {});
  EXPECT_EQ(touching.distance_m(), Bytes(touched.distance_m));
  EXPECT_EQ(touching.row_begin(), Bytes(touched.row_begin));
  v1::CheckMotionsRequest move;
  *move.mutable_subject() = Arm(rows);
  for (int i = 0; i < 100; ++i) move.add_path_row_counts(5);
  std::vector<collision::Path> paths;
  for (std::size_t k = 0; k < 100; ++k) paths.push_back({.first_row = 5 * k, .row_count = 5});
  const v1::CheckMotionsResponse moved = Move(move);
  const auto motions = *collision::CheckPaths(
      *world, body, collision::JointWaypoints(robot->model(), body, states), paths, {});
  EXPECT_EQ(moved.segment(), Bytes(motions.segment));
  EXPECT_EQ(moved.lo(), Bytes(motions.lo));
  EXPECT_EQ(moved.hi(), Bytes(motions.hi));
  EXPECT_EQ(moved.clearance_m(), Bytes(motions.clearance_m));
  EXPECT_EQ(moved.object_index(), Bytes(motions.object));
  EXPECT_EQ(moved.trust().size(), motions.accuracy.size());
  for (const char some : {v1::MOTION_VERDICT_CONTACT, v1::MOTION_VERDICT_OUT_OF_LIMITS}) {
    EXPECT_THAT(moved.verdicts(), ::testing::Contains(some));
  }
}

TEST_F(RobotQueries, StandWhereTheyAreUnlessTheOverlayOrTheQuerySaysOtherwise) {
  v1::CheckCollisionsRequest request;
  *request.mutable_subject() = Arm({});
  EXPECT_EQ(Check(request).verdicts(), "\x02") << "outstretched, as it was loaded: in the post";
  request.mutable_subject()->mutable_robot()->mutable_base_state()->set_group("arm");
  request.mutable_subject()->mutable_robot()->mutable_base_state()->set_named_state("side");
  EXPECT_EQ(Check(request).verdicts(), "\x01");
  request.mutable_subject()->mutable_robot()->clear_base_state();
  request.mutable_subject()->mutable_robot()->mutable_x_world_base()->set_tz_m(1);
  request.mutable_subject()->mutable_robot()->mutable_x_world_base()->set_qw(1);
  EXPECT_EQ(Check(request).verdicts(), "\x01");
  request.mutable_subject()->mutable_robot()->clear_x_world_base();
  v1::SetRobotState* set = request.mutable_options()->add_overlay()->mutable_robot_state();
  set->set_name("r");
  v1::VariableValue* shoulder = set->mutable_joints()->add_values();
  shoulder->set_variable("shoulder");
  shoulder->set_value(1.5);
  EXPECT_EQ(Check(request).verdicts(), "\x01");
  shoulder->set_value(0);
  set->mutable_x_world_base()->set_tx_m(0.4);
  set->mutable_x_world_base()->set_qw(1);
  const v1::CheckCollisionsResponse moved = Check(request);
  EXPECT_EQ(moved.verdicts(), "\x02");
  EXPECT_EQ(moved.body_part(), Bytes<std::int32_t>({1})) << "now the middle ball";
}

TEST_F(RobotQueries, OfSpheresAnswerWithoutClaims) {
  v1::CheckCollisionsRequest request;
  *request.mutable_subject() = Arm(RandomRows(100));
  const std::string exact = Check(request).verdicts();
  request.mutable_subject()->mutable_robot()->set_robot_geometry(
      v1::ROBOT_GEOMETRY_SPHERES_AS_GIVEN);
  const v1::CheckCollisionsResponse response = Check(request);
  EXPECT_EQ(response.verdicts(), exact) << "the spheres are the links' own shapes";
  EXPECT_THAT(response.trust(), Each(static_cast<char>(v1::TRUST_DEGRADED)));
  Load("bare", false);
  request.mutable_subject()->mutable_robot()->set_robot("bare");
  const grpc::Status none = Refused(request);
  EXPECT_EQ(none.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(ReasonIn(none), "NO_SPHERES");
}

TEST_F(RobotQueries, OfSpheresThatContainItAreFreeOnlyWhereItIs) {
  v1::CheckCollisionsRequest request;
  *request.mutable_subject() = Arm(RandomRows(500));
  const std::string exact = Check(request).verdicts();
  request.mutable_subject()->mutable_robot()->set_robot_geometry(
      v1::ROBOT_GEOMETRY_SPHERES_CONTAINING);
  const std::string around = Check(request).verdicts();
  ASSERT_EQ(around.size(), exact.size());
  int free = 0;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    if (around[k] == static_cast<char>(v1::VERDICT_UNDECIDED)) continue;
    EXPECT_EQ(exact[k], around[k]) << k;
    free += around[k] == static_cast<char>(v1::VERDICT_FREE);
  }
  EXPECT_GT(free, 50);
}

TEST_F(RobotQueries, ByVerdictsOnlyNameNoPairs) {
  v1::CheckCollisionsRequest request;
  *request.mutable_subject() = Arm(RandomRows(500));
  const v1::CheckCollisionsResponse named = Check(request);
  request.mutable_options()->set_verdicts_only(true);
  const v1::CheckCollisionsResponse verdicts = Check(request);
  EXPECT_EQ(verdicts.verdicts(), named.verdicts());
  EXPECT_EQ(verdicts.trust(), named.trust());
  EXPECT_FALSE(named.object_index().empty());
  EXPECT_TRUE(verdicts.object_index().empty() && verdicts.body_part().empty());
}

TEST_F(RobotQueries, BadRowsGroupsAndNamesAreTold) {
  v1::CheckCollisionsRequest request;
  *request.mutable_subject() = Arm({0, 0, 0, std::numeric_limits<double>::quiet_NaN()});
  EXPECT_EQ(FieldIn(Refused(request)), "subject.robot.rows.data row 1");
  EXPECT_THAT(Refused(request).error_message(), HasSubstr("elbow is nan"));
  *request.mutable_subject() = Arm({0, 0, 0});
  EXPECT_EQ(FieldIn(Refused(request)), "subject.robot.rows.data");
  *request.mutable_subject() = Arm({0, 0});
  request.mutable_subject()->mutable_robot()->set_group("leg");
  EXPECT_EQ(FieldIn(Refused(request)), "subject.robot.group");
  EXPECT_THAT(Refused(request).error_message(), HasSubstr("\"arm\""));
  request.mutable_subject()->mutable_robot()->set_robot("ghost");
  EXPECT_EQ(Refused(request).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReasonIn(Refused(request)), "ROBOT_UNKNOWN");
  *request.mutable_subject() = Arm(std::vector<double>(std::size_t{2} * 65'537, 0.0));
  EXPECT_THAT(Refused(request).error_message(),
              HasSubstr("has 65537 rows, must have at most 65536"));
}

TEST_F(RobotQueries, MotionsAreFreeOrMeetSomething) {
  v1::CheckMotionsRequest request;
  *request.mutable_subject() = Arm({1, 0, 2, 0, 1, 0, -1, 0, 1, 0, 1, 3, 1, 0, 3.1, 0});
  request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  const v1::CheckMotionsResponse response = Move(request);
  EXPECT_EQ(response.completed_count(), 4);
  ASSERT_EQ(response.rows_size(), 4);
  EXPECT_EQ(response.rows(0).verdict(), v1::MOTION_VERDICT_FREE);
  EXPECT_GT(response.rows(0).clearance_m(), 0);
  EXPECT_EQ(response.rows(1).verdict(), v1::MOTION_VERDICT_CONTACT);
  EXPECT_EQ(response.rows(1).object(), "post");
  EXPECT_EQ(response.rows(1).body_link(), "e");
  // The hand's ball touches the box's side, 0.1 m beside the line to its centre.
  const double at_rad = 1 - 2 * response.rows(1).hi();
  EXPECT_NEAR(std::sin(at_rad), 0.2, 0.002);
  EXPECT_EQ(response.rows(2).verdict(), v1::MOTION_VERDICT_CONTACT);
  EXPECT_EQ(response.rows(2).body_link(), "a");
  EXPECT_EQ(response.rows(2).object_link(), "e");
  EXPECT_EQ(response.rows(3).verdict(), v1::MOTION_VERDICT_OUT_OF_LIMITS);
  EXPECT_EQ(response.rows(3).segment(), 1);
  request.add_path_row_counts(3);
  request.add_path_row_counts(5);
  const v1::CheckMotionsResponse paths = Move(request);
  ASSERT_EQ(paths.rows_size(), 2);
  EXPECT_EQ(paths.rows(0).verdict(), v1::MOTION_VERDICT_FREE);
  EXPECT_EQ(paths.rows(1).verdict(), v1::MOTION_VERDICT_OUT_OF_LIMITS);
  EXPECT_EQ(paths.rows(1).segment(), 4);
  EXPECT_EQ(response.rows(3).variable(), "shoulder");
  EXPECT_EQ(paths.rows(1).variable(), "shoulder");
  EXPECT_FALSE(paths.rows(0).has_variable());
}

// A ball half a metre in front of a link that turns at (x, 0) from heading 2.5 to -2.5: the short
// way passes through pi.
TEST_F(RobotQueries, MotionsOfPlanarAndFloatingJointsTurnTheShortWay) {
  PutBox("box", 10);
  const double z = std::sin(1.25), w = std::cos(1.25);
  const auto rows_at = [&](const std::string& kind, double x_m) {
    if (kind == "planar") return std::vector<double>{x_m, 0, 2.5, x_m, 0, -2.5};
    return std::vector<double>{x_m, 0, 0, 0, 0, z, w, x_m, 0, 0, 0, 0, -z, w};
  };
  for (const std::string kind : {"planar", "floating"}) {
    v1::LoadRobotRequest load;
    load.mutable_header()->set_urdf(Robot(
        Links("wb") + Ball("hand") + JointText("moves", kind, "w", "b", "<axis xyz=\"0 0 1\"/>") +
        JointText("ahead", "fixed", "b", "hand", "<origin xyz=\"0.5 0 0\"/>")));
    LoadRobot(kind, load.header());
    const auto verdicts_at = [&](double x_m) {
      v1::CheckMotionsRequest request;
      request.mutable_subject()->mutable_robot()->set_robot(kind);
      request.mutable_subject()->mutable_robot()->mutable_rows()->set_data(
          Bytes(rows_at(kind, x_m)));
      return Move(request).verdicts();
    };
    EXPECT_EQ(verdicts_at(10.5), std::string(1, v1::MOTION_VERDICT_CONTACT)) << kind;
    EXPECT_EQ(verdicts_at(9.5), std::string(1, v1::MOTION_VERDICT_FREE)) << kind;
  }
}

TEST_F(RobotQueries, MotionsOfSpheresAreLabelledLikeTheirStates) {
  v1::CheckMotionsRequest request;
  *request.mutable_subject() = Arm({1, 0, 2, 0, 1, 0, -1, 0});
  EXPECT_EQ(Move(request).trust(), std::string(2, v1::TRUST_EXACT));
  v1::RobotSubject& robot = *request.mutable_subject()->mutable_robot();
  robot.set_robot_geometry(v1::ROBOT_GEOMETRY_SPHERES_AS_GIVEN);
  const v1::CheckMotionsResponse as_given = Move(request);
  EXPECT_EQ(as_given.verdicts(), "\x01\x02");  // free, and in contact
  EXPECT_EQ(as_given.trust(), std::string(2, v1::TRUST_DEGRADED));
  robot.set_robot_geometry(v1::ROBOT_GEOMETRY_SPHERES_CONTAINING);
  const v1::CheckMotionsResponse containing = Move(request);
  EXPECT_EQ(containing.verdicts(), "\x01\x04");  // free, and undecided
  EXPECT_EQ(containing.trust(), std::string({v1::TRUST_EXACT, v1::TRUST_DEGRADED}));
}

TEST_F(RobotQueries, MotionsOfShapesAndObjectsKeepMarginsAndLeaveOutWhatTheyAreTold) {
  PutBox("cart", 5);
  v1::CheckMotionsRequest request;
  v1::Subject::WorldObject* cart = request.mutable_subject()->mutable_object();
  cart->set_name("cart");
  // Passes the post at a distance of 0.01 m and through the cart's own place.
  cart->mutable_x_world_object()->set_data(
      Bytes<double>({-5, 0.21, 0, 0, 0, 0, 1, 5, 0.21, 0, 0, 0, 0, 1}));
  v1::CheckMotionsResponse free = Move(request);
  EXPECT_EQ(free.verdicts(), std::string(1, v1::MOTION_VERDICT_FREE));
  EXPECT_THAT(free.body_links(), ElementsAre());
  request.mutable_options()->set_margin_m(0.011);
  const v1::CheckMotionsResponse met = Move(request);
  ASSERT_EQ(met.objects_size(), 1);
  EXPECT_EQ(met.objects(0).name(), "r") << "the robot stands in the way";
  request.mutable_options()->add_ignore("r");
  const v1::CheckMotionsResponse contact = Move(request);
  EXPECT_EQ(contact.verdicts(), std::string(1, v1::MOTION_VERDICT_CONTACT));
  EXPECT_EQ(contact.objects(0).name(), "post");
  request.mutable_options()->add_ignore("post");
  EXPECT_EQ(Move(request).verdicts(), std::string(1, v1::MOTION_VERDICT_FREE));
  request.mutable_options()->mutable_ignore()->RemoveLast();
  request.mutable_options()->add_overlay()->mutable_remove()->set_name("post");
  EXPECT_EQ(Move(request).verdicts(), std::string(1, v1::MOTION_VERDICT_FREE));
  v1::CheckMotionsRequest ball;
  *ball.mutable_subject() = SphereAt({-1, 0.5, 0.5, 3});
  ball.mutable_options()->add_ignore("r");
  EXPECT_EQ(Move(ball).verdicts(),
            std::string({v1::MOTION_VERDICT_FREE, v1::MOTION_VERDICT_CONTACT}));
}

// Otherwise a misspelled name would silently ignore nothing.
TEST_F(RobotQueries, LinksOfPairsThatAreIgnoredAreThere) {
  v1::CheckCollisionsRequest request;
  *request.mutable_subject() = Arm({0, 0});
  const auto ask = [&](const std::string& name, const std::string& link) {
    request.mutable_options()->clear_ignore_pairs();
    v1::NamedPair* pair = request.mutable_options()->add_ignore_pairs();
    pair->mutable_a()->set_name("post");
    pair->mutable_b()->set_name(name);
    pair->mutable_b()->set_link(link);
    Call call;
    v1::CheckCollisionsResponse response;
    return query_->CheckCollisions(&call, request, &response);
  };
  EXPECT_TRUE(ask("r", "e").ok());
  EXPECT_TRUE(ask("nobody", "e").ok());
  const grpc::Status refused = ask("r", "hand");
  EXPECT_EQ(FieldIn(refused), "options.ignore_pairs[0].b.link");
  EXPECT_THAT(refused.error_message(), HasSubstr("is 'hand', must be a link of robot 'r'"));
  EXPECT_EQ(FieldIn(ask("post", "e")), "options.ignore_pairs[0].b.link");
}

TEST_F(RobotQueries, MotionsThatCannotBeAreRefused) {
  v1::CheckMotionsRequest request;
  *request.mutable_subject() = Arm({0, 0, 1, 1, 2, 2});
  EXPECT_EQ(FieldIn(Refused(request)), "subject");
  request.add_path_row_counts(4);
  EXPECT_EQ(FieldIn(Refused(request)), "path_row_counts");
  request.set_path_row_counts(0, 1);
  EXPECT_EQ(FieldIn(Refused(request)), "path_row_counts[0]");
  request.set_path_row_counts(0, 3);
  request.mutable_options()->set_engine(v1::ENGINE_FCL);
  EXPECT_EQ(Refused(request).error_code(), grpc::StatusCode::UNIMPLEMENTED);
  const double points[6] = {0, 0, 0, 1, 1, 1};
  request.mutable_subject()->mutable_points()->set_data(points, sizeof(points));
  EXPECT_EQ(FieldIn(Refused(request)), "subject.points");
  request.mutable_options()->clear_engine();
  *request.mutable_subject() = Arm(std::vector<double>(std::size_t{4} * 1'025, 0.0));
  request.clear_path_row_counts();
  request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  EXPECT_EQ(FieldIn(Refused(request)), "options.result_form");
}

TEST_F(RobotQueries, ATimeBudgetGivesThePrefixOfTheMotions) {
  v1::CheckMotionsRequest request;
  *request.mutable_subject() = Arm(RandomRows(65'536));
  request.mutable_options()->mutable_time_budget()->set_nanos(2'000'000);
  const v1::CheckMotionsResponse part = Move(request);
  EXPECT_LT(part.completed_count(), 32'768);
  const auto done = static_cast<std::size_t>(part.completed_count());
  EXPECT_EQ(part.verdicts().size(), 32'768u);
  EXPECT_THAT(part.verdicts().substr(done),
              Each(static_cast<char>(v1::MOTION_VERDICT_NOT_COMPUTED)));
  std::vector<double> rows = RandomRows(65'536);
  rows.resize(4 * done);
  request.mutable_options()->clear_time_budget();
  *request.mutable_subject() = Arm(rows);
  if (done == 0) return;
  const v1::CheckMotionsResponse full = Move(request);
  EXPECT_EQ(full.verdicts(), part.verdicts().substr(0, done));
  EXPECT_EQ(full.lo(), part.lo().substr(0, done * sizeof(double)));
}

TEST_F(RobotQueries, AStreamAnswersRobotsAndMotionsAsTheUnaryCallsDo) {
  Call call;
  const auto stream = query_->StreamQueries(&call);
  v1::StreamQueriesRequest request;
  v1::StreamQueriesResponse response;
  *request.mutable_check_collisions()->mutable_subject() = Arm(RandomRows(50));
  ASSERT_TRUE(stream->Write(request) && stream->Read(&response));
  EXPECT_EQ(response.check_collisions().SerializeAsString(),
            Check(request.check_collisions()).SerializeAsString());
  *request.mutable_check_motions()->mutable_subject() = Arm(RandomRows(50));
  ASSERT_TRUE(stream->Write(request) && stream->Read(&response));
  EXPECT_EQ(response.check_motions().SerializeAsString(),
            Move(request.check_motions()).SerializeAsString());
  request.mutable_check_motions()->mutable_options()->mutable_at_revision()->set_exact(77);
  ASSERT_TRUE(stream->Write(request) && stream->Read(&response));
  EXPECT_EQ(response.error().reason(), "REVISION_IN_FUTURE");
  request.clear_query();
  ASSERT_TRUE(stream->Write(request) && stream->Read(&response));
  EXPECT_THAT(response.error().message(), HasSubstr("check_motions"));
}

}  // namespace
}  // namespace cwm::server
