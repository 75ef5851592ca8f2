// Queries about chosen pairs, over a real socket: distances link by link, their gradients by
// joints, queries of named members only, and points per pair.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <vector>

#include "tests/collision/robot/robot_text.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using collision::testing::Robot;
using collision::testing::ThreeBalls;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pointwise;

constexpr double kExact_m = 1e-7;  // the accuracy of answers labelled EXACT
const double kRoot = std::sqrt(2.0);

template <class Number>
std::vector<Number> Numbers(const std::string& bytes) {
  std::vector<Number> values(bytes.size() / sizeof(Number));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

auto AreNear(std::vector<double> values) {
  return Pointwise(DoubleNear(kExact_m), std::move(values));
}

// The arm "r" of three balls a, c and e with radii of 0.1 m, 0.5 m apart, at the origin; a box
// "post" with edges of 0.2 m at (1, 0, 0), and a box "far" at (5, 0, 0).
class PairOptions : public RunningServer {
 protected:
  using RunningServer::RunningServer;

  void SetUp() override {
    v1::LoadRobotHeader header;
    header.set_urdf(Robot(ThreeBalls()));
    header.set_srdf("<robot name=\"r\"/>");  // all pairs of links are tested
    LoadRobot("r", header);
    PutBox("post", 1);
    PutBox("far", 5);
  }
  // The arm stretched along y, with its last ball at (0, 1, 0).
  static v1::GetDistancesRequest AlongY(v1::DistancePairs pairs) {
    v1::GetDistancesRequest request;
    request.set_pairs(pairs);
    v1::RobotSubject* robot = request.mutable_subject()->mutable_robot();
    robot->set_robot("r");
    const std::vector<double> row = {std::numbers::pi / 2, 0};
    robot->mutable_rows()->set_data(
        std::string(reinterpret_cast<const char*>(row.data()), row.size() * sizeof(double)));
    return request;
  }
  v1::GetDistancesResponse Distances(const v1::GetDistancesRequest& request) {
    Call call;
    v1::GetDistancesResponse response;
    const auto status = query_->GetDistances(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }
  grpc::Status Refused(const v1::GetDistancesRequest& request) {
    Call call;
    v1::GetDistancesResponse ignored;
    return query_->GetDistances(&call, request, &ignored);
  }
  static v1::NamedThing* Add(const std::string& name, const std::string& link,
                             v1::QueryOptions* options) {
    v1::NamedThing* thing = options->add_only();
    thing->set_name(name);
    thing->set_link(link);
    return thing;
  }
};

TEST_F(PairOptions, DistancesLinkByLinkWithinARadius) {
  v1::GetDistancesRequest request = AlongY(v1::DISTANCE_PAIRS_LINKS);
  request.mutable_options()->set_max_distance_m(0.9);
  const v1::GetDistancesResponse columns = Distances(request);
  // Of a: c, and e and the post as near; of c: e, and the post's edge at (0.9, 0.1).
  const double c_to_post_m = std::hypot(0.9, 0.4) - 0.1;
  EXPECT_THAT(Numbers<double>(columns.columns().distance_m()),
              AreNear({0.3, 0.8, 0.8, 0.3, c_to_post_m}));
  EXPECT_THAT(Numbers<std::int32_t>(columns.columns().body_part()), ElementsAre(0, 0, 0, 1, 1));
  EXPECT_THAT(Numbers<std::int32_t>(columns.columns().object_index()),
              ElementsAre(-2, -2, 0, -2, 0));
  EXPECT_THAT(columns.variables(), IsEmpty());
  EXPECT_THAT(columns.columns().joint_gradient(), IsEmpty());
  request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  const v1::GetDistancesResponse rows = Distances(request);
  ASSERT_EQ(rows.rows_size(), 1);
  ASSERT_EQ(rows.rows(0).answers_size(), 5);
  const v1::PairRow& last = rows.rows(0).answers(4);
  EXPECT_EQ(last.body_link(), "c");
  EXPECT_EQ(last.object(), "post");
  EXPECT_NEAR(last.distance_m(), c_to_post_m, kExact_m);
  EXPECT_EQ(last.joint_gradient_size(), 0);
}

TEST_F(PairOptions, GradientsAreLeversOfTheJoints) {
  v1::GetDistancesRequest request = AlongY(v1::DISTANCE_PAIRS_LINKS);
  request.set_want_joint_gradient(true);
  request.mutable_options()->set_max_results(1);
  Add("post", "", request.mutable_options());
  const v1::GetDistancesResponse columns = Distances(request);
  // The normal from e to the edge at (0.9, 0.1) is (1, -1) / sqrt(2). Both joints turn e in -x, the
  // shoulder with a lever of 1 m and the elbow with one of 0.5 m.
  const double e_to_post_m = 0.9 * kRoot - 0.1;
  const double c_to_post_m = std::hypot(0.9, 0.4) - 0.1,
               c_lever_m = 0.5 * 0.9 / std::hypot(0.9, 0.4);
  EXPECT_THAT(Numbers<double>(columns.columns().distance_m()),
              AreNear({0.8, c_to_post_m, e_to_post_m}));
  EXPECT_THAT(columns.variables(), ElementsAre("shoulder", "elbow"));
  EXPECT_THAT(Numbers<double>(columns.columns().joint_gradient()),
              AreNear({0, 0, c_lever_m, 0, 1 / kRoot, 0.5 / kRoot}));
  EXPECT_EQ(columns.columns().gradient_kink(), std::string(3, '\0'));
  request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  const v1::GetDistancesResponse rows = Distances(request);
  EXPECT_THAT(rows.variables(), ElementsAre("shoulder", "elbow"));
  EXPECT_THAT(rows.rows(0).answers(2).joint_gradient(), AreNear({1 / kRoot, 0.5 / kRoot}));
  // With one answer for the whole robot, and in single precision.
  request.set_pairs(v1::DISTANCE_PAIRS_OBJECTS);
  request.mutable_options()->set_result_form(v1::RESULT_FORM_COLUMNS);
  request.mutable_options()->set_scalar(v1::SCALAR_F32);
  EXPECT_THAT(Numbers<float>(Distances(request).columns().joint_gradient()), ElementsAre(0, 0));
}

TEST_F(PairOptions, AStreamAnswersAsTheUnaryCallDoes) {
  v1::StreamQueriesRequest request;
  v1::StreamQueriesResponse response;
  *request.mutable_get_distances() = AlongY(v1::DISTANCE_PAIRS_LINKS);
  request.mutable_get_distances()->set_want_joint_gradient(true);
  request.mutable_get_distances()->mutable_options()->set_max_results(2);
  Call call;
  const auto stream = query_->StreamQueries(&call);
  ASSERT_TRUE(stream->Write(request) && stream->Read(&response));
  EXPECT_EQ(response.get_distances().SerializeAsString(),
            Distances(request.get_distances()).SerializeAsString());
  EXPECT_EQ(response.get_distances().columns().gradient_kink().size(), 6u);
}

TEST_F(PairOptions, OnlyNamedMembersAreTested) {
  v1::GetDistancesRequest request = AlongY(v1::DISTANCE_PAIRS_OBJECTS);
  request.mutable_options()->set_max_results(9);
  const auto distances = [&] { return Numbers<double>(Distances(request).columns().distance_m()); };
  EXPECT_EQ(distances().size(), 3u);
  Add("far", "", request.mutable_options());
  EXPECT_THAT(distances(), AreNear({4.8}));
  Add("r", "e", request.mutable_options());
  EXPECT_THAT(distances(), AreNear({0.3, std::hypot(4.9, 0.9) - 0.1}));
  request.mutable_options()->clear_only();
  Add("r", "", request.mutable_options());
  EXPECT_THAT(distances(), AreNear({0.3}));
  // An object of the overlay counts as well.
  request.mutable_options()->clear_only();
  Add("near", "", request.mutable_options());
  *request.mutable_options()->add_overlay() = PutBoxChange("near", 3);
  EXPECT_THAT(distances(), AreNear({2.8}));
}

// Otherwise a misspelled name would silently find nothing.
TEST_F(PairOptions, NamesThatTheWorldDoesNotHaveAreRefused) {
  v1::GetDistancesRequest request = AlongY(v1::DISTANCE_PAIRS_OBJECTS);
  const auto refused = [&](const std::string& name, const std::string& link) {
    request.mutable_options()->clear_only();
    Add("post", "", request.mutable_options());
    Add(name, link, request.mutable_options());
    return Refused(request);
  };
  EXPECT_TRUE(refused("r", "e").ok());
  EXPECT_EQ(FieldIn(refused("*", "")), "options.only[1].name");
  EXPECT_EQ(FieldIn(refused("", "e")), "options.only[1].name");
  const auto unknown = refused("pots", "");
  EXPECT_EQ(FieldIn(unknown), "options.only[1].name");
  EXPECT_THAT(unknown.error_message(),
              HasSubstr("is \"pots\", must be an object or a robot of the world"));
  const auto no_link = refused("r", "hand");
  EXPECT_EQ(FieldIn(no_link), "options.only[1].link");
  EXPECT_THAT(no_link.error_message(), HasSubstr("must be a link of robot \"r\""));
  EXPECT_THAT(refused("post", "e").error_message(), HasSubstr("which has no links"));
  request.mutable_subject()->mutable_object()->set_name("far");
  EXPECT_TRUE(refused("r", "").ok());
  EXPECT_THAT(refused("far", "").error_message(), HasSubstr("not tested against itself"));
  request.mutable_options()->clear_only();
  for (int k = 0; k < 4'097; ++k) Add("post", "", request.mutable_options());
  EXPECT_EQ(FieldIn(Refused(request)), "options.only");
  // Rays, points and motions check the names as well.
  v1::CastRaysRequest rays;
  Add("pots", "", rays.mutable_options());
  Call call;
  v1::CastRaysResponse ignored;
  EXPECT_EQ(FieldIn(query_->CastRays(&call, rays, &ignored)), "options.only[0].name");
}

TEST_F(PairOptions, OptionsThatContradictEachOtherAreRefused) {
  v1::GetDistancesRequest request = AlongY(static_cast<v1::DistancePairs>(7));
  EXPECT_EQ(FieldIn(Refused(request)), "pairs");
  request = AlongY(v1::DISTANCE_PAIRS_LINKS);
  const auto without_radius = Refused(request);
  EXPECT_EQ(FieldIn(without_radius), "options.max_distance_m");
  EXPECT_THAT(without_radius.error_message(), HasSubstr("is absent, must be given"));
  request.mutable_options()->set_max_results(-1);
  EXPECT_EQ(FieldIn(Refused(request)), "options.max_results");
  request.mutable_options()->set_max_results(65);
  EXPECT_EQ(FieldIn(Refused(request)), "options.max_results");
  v1::GetDistancesRequest of_sphere;
  *of_sphere.mutable_subject() = SphereAt({0.5});
  of_sphere.set_want_joint_gradient(true);
  EXPECT_EQ(FieldIn(Refused(of_sphere)), "want_joint_gradient");
  v1::GetContactsRequest contacts;
  *contacts.mutable_subject() = SphereAt({0.5});
  for (const int count : {-1, 1'025}) {
    contacts.set_max_contacts_per_pair(count);
    Call call;
    v1::GetContactsResponse ignored;
    EXPECT_EQ(FieldIn(query_->GetContacts(&call, contacts, &ignored)), "max_contacts_per_pair");
  }
}

TEST_F(PairOptions, PointsOfAPairAreLimited) {
  v1::GetContactsRequest request;
  v1::Subject::Shapes* shapes = request.mutable_subject()->mutable_shapes();
  v1::Box* box = shapes->add_shapes()->mutable_box();
  box->set_size_x_m(0.1);
  box->set_size_y_m(0.1);
  box->set_size_z_m(0.1);
  const std::vector<double> on_box = {5, 0, 0.149, 0, 0, 0, 1};
  shapes->mutable_x_world_body()->set_data(
      std::string(reinterpret_cast<const char*>(on_box.data()), on_box.size() * sizeof(double)));
  const auto count = [&](int of_pair) {
    request.set_max_contacts_per_pair(of_pair);
    Call call;
    v1::GetContactsResponse response;
    const auto status = query_->GetContacts(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return Numbers<double>(response.columns().distance_m()).size();
  };
  EXPECT_GE(count(0), 4u);
  EXPECT_EQ(count(1), 1u);
  EXPECT_EQ(count(3), 3u);
}

// At most 8 answers in a batch, and 4 as messages.
class FewAnswers : public PairOptions {
 protected:
  FewAnswers()
      : PairOptions(
            [] {
              Limits limits;
              limits.max_answers = 8;
              limits.max_answers_as_messages = 4;
              return limits;
            }(),
            Retention{}) {}
};

TEST_F(FewAnswers, LinkPairsBeyondTheLimitAreRefusedByTheirOption) {
  v1::GetDistancesRequest request = AlongY(v1::DISTANCE_PAIRS_LINKS);
  request.mutable_options()->set_max_distance_m(0.9);
  EXPECT_TRUE(Refused(request).ok());  // five answers
  request.set_want_joint_gradient(true);
  EXPECT_TRUE(Refused(request).ok());  // six of 116 bytes take as much as eight of 100
  request.mutable_options()->set_max_distance_m(9);
  const auto too_far = Refused(request);
  EXPECT_EQ(FieldIn(too_far), "options.max_distance_m");
  EXPECT_THAT(too_far.error_message(), HasSubstr("more than 6 answers"));
  request.mutable_options()->set_max_results(64);
  EXPECT_EQ(FieldIn(Refused(request)), "options.max_results");
  request = AlongY(v1::DISTANCE_PAIRS_LINKS);
  request.mutable_options()->set_max_distance_m(0.9);
  request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  EXPECT_EQ(FieldIn(Refused(request)), "options.max_distance_m");
}

}  // namespace
}  // namespace cwm::server
