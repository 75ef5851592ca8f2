// Answers received as columns are converted to the same rows that the server would send.
#include "clients/cli/row_columns.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <initializer_list>
#include <limits>
#include <string>
#include <vector>

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

template <class Number>
std::string Bytes(const std::vector<Number>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number));
}
std::string Bytes(std::initializer_list<std::int32_t> values) {
  return Bytes(std::vector<std::int32_t>(values));
}

// Three verdicts: free, in collision with the cup, in collision with itself.
pb::CheckCollisionsResponse RobotChecked() {
  pb::CheckCollisionsResponse response;
  response.add_objects()->set_name("cup");
  for (const char* link : {"base", "hand"}) response.add_body_links(link);
  response.set_verdicts("\x01\x02\x02");
  response.set_trust("\x01\x04\x04");
  response.set_object_index(Bytes({-1, 0, -2}));
  response.set_body_part(Bytes({-1, 1, 0}));
  response.set_object_part(Bytes({-1, 7, 1}));
  return response;
}

TEST(ExpandRows, NamesObjectsAndLinks) {
  pb::CheckCollisionsResponse response = RobotChecked();
  ASSERT_TRUE(ExpandRows(response).ok());
  ASSERT_EQ(response.rows_size(), 3);
  EXPECT_EQ(response.rows(0).verdict(), pb::VERDICT_FREE);
  EXPECT_EQ(response.rows(0).trust(), pb::TRUST_EXACT);
  EXPECT_FALSE(response.rows(0).has_object() || response.rows(0).has_body_link());
  EXPECT_EQ(response.rows(1).object(), "cup");
  EXPECT_EQ(response.rows(1).object_part(), 7);
  EXPECT_EQ(response.rows(1).body_link(), "hand");
  EXPECT_EQ(response.rows(1).trust(), pb::TRUST_DEGRADED);
  EXPECT_FALSE(response.rows(2).has_object());
  EXPECT_EQ(response.rows(2).body_link(), "base");
  EXPECT_EQ(response.rows(2).object_link(), "hand");
  EXPECT_TRUE(response.verdicts().empty() && response.trust().empty());
}

TEST(ExpandRows, NamesWhatIsOutOfItsLimits) {
  pb::CheckCollisionsResponse response = RobotChecked();
  for (const char* variable : {"shoulder", "elbow"}) response.add_variables(variable);
  response.set_variable_index(Bytes({1, -1, -1}));
  pb::CheckCollisionsResponse bad = response;
  ASSERT_TRUE(ExpandRows(response).ok());
  EXPECT_EQ(response.rows(0).variable(), "elbow");
  EXPECT_FALSE(response.rows(1).has_variable());
  EXPECT_TRUE(response.variable_index().empty() && response.variables().empty());
  bad.set_variable_index(Bytes({2, -1, -1}));
  EXPECT_EQ(ExpandRows(bad).code(), absl::StatusCode::kDataLoss);
  bad.set_variable_index(Bytes({1, -1}));
  EXPECT_EQ(ExpandRows(bad).code(), absl::StatusCode::kDataLoss);
}

TEST(ExpandRows, NamesWhatIsCarriedAndLinksOfOtherRobots) {
  pb::CheckCollisionsResponse response = RobotChecked();
  for (const char* link : {"base", "hand"}) response.mutable_objects(0)->add_part_links(link);
  for (const char* object : {"", "mug"}) response.add_body_objects(object);
  response.set_object_part(Bytes({-1, 1, 1}));
  ASSERT_TRUE(ExpandRows(response).ok());
  EXPECT_EQ(response.rows(1).object_link(), "hand") << "of the robot that is called cup";
  EXPECT_EQ(response.rows(1).body_object(), "mug");
  EXPECT_FALSE(response.rows(2).has_body_object());
  EXPECT_EQ(response.rows(2).object(), "mug");
  EXPECT_EQ(response.rows(2).object_link(), "hand");
}

// One row with four distances from the cup.
pb::GetDistancesResponse FourDistances() {
  pb::GetDistancesResponse response;
  response.add_objects()->set_name("cup");
  pb::PairColumns& columns = *response.mutable_columns();
  columns.set_row_begin(Bytes(std::vector<std::uint32_t>{0, 4}));
  columns.set_distance_m(Bytes(std::vector<double>(4)));
  for (std::string* vectors :
       {columns.mutable_point_body(), columns.mutable_point_object(), columns.mutable_normal()}) {
    *vectors = Bytes(std::vector<double>(12));
  }
  for (std::string* indices : {columns.mutable_object_index(), columns.mutable_body_part(),
                               columns.mutable_object_part()}) {
    *indices = Bytes({0, 0, 0, 0});
  }
  columns.set_trust("\x01\x02\x03\x04");
  return response;
}

TEST(ExpandRows, CarriesGradientsByTheVariables) {
  pb::GetDistancesResponse response = FourDistances();
  for (const char* variable : {"shoulder", "elbow"}) response.add_variables(variable);
  response.mutable_columns()->set_joint_gradient(
      Bytes(std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8}));
  response.mutable_columns()->set_gradient_kink(std::string("\0\1\0\0", 4));
  pb::GetDistancesResponse bad = response;
  ASSERT_TRUE(ExpandRows(response).ok());
  const auto& answers = response.rows(0).answers();
  EXPECT_EQ(answers[1].joint_gradient_size(), 2);
  EXPECT_EQ(answers[1].joint_gradient(0), 3);
  EXPECT_EQ(answers[3].joint_gradient(1), 8);
  EXPECT_TRUE(answers[1].gradient_kink());
  EXPECT_FALSE(answers[2].gradient_kink());
  bad.mutable_columns()->mutable_joint_gradient()->pop_back();
  EXPECT_EQ(ExpandRows(bad).code(), absl::StatusCode::kDataLoss);
}

TEST(ExpandRows, CarriesTheBoundsOfWhatIsBoundedOrASurfaceAlone) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  pb::GetDistancesResponse response = FourDistances();
  pb::PairColumns& columns = *response.mutable_columns();
  columns.set_bound_m(Bytes(std::vector<double>{0, 0.125, 0.25, kNone}));
  ASSERT_TRUE(ExpandRows(response).ok());
  const auto& answers = response.rows(0).answers();
  EXPECT_FALSE(answers[0].has_bound_m());
  EXPECT_EQ(answers[1].bound_m(), 0.125);
  EXPECT_EQ(answers[2].bound_m(), 0.25);
  EXPECT_FALSE(answers[3].has_bound_m());
}

TEST(ExpandRows, RefusesWhatNamesNothing) {
  for (const std::int32_t object : {1, -3}) {
    pb::CheckCollisionsResponse response = RobotChecked();
    response.set_object_index(Bytes({-1, object, -2}));
    EXPECT_EQ(ExpandRows(response).code(), absl::StatusCode::kDataLoss) << object;
  }
  for (const std::int32_t part : {2, -1}) {
    pb::CheckCollisionsResponse response = RobotChecked();
    response.set_object_part(Bytes({-1, 7, part}));
    EXPECT_EQ(ExpandRows(response).code(), absl::StatusCode::kDataLoss) << part;
  }
  pb::CheckCollisionsResponse no_such_part = RobotChecked();
  no_such_part.mutable_objects(0)->add_part_links("base");
  EXPECT_EQ(ExpandRows(no_such_part).code(), absl::StatusCode::kDataLoss);
  pb::CheckCollisionsResponse too_few = RobotChecked();
  too_few.add_body_objects("");
  EXPECT_EQ(ExpandRows(too_few).code(), absl::StatusCode::kDataLoss);
  pb::CheckCollisionsResponse no_robot = RobotChecked();
  no_robot.clear_body_links();
  EXPECT_EQ(ExpandRows(no_robot).code(), absl::StatusCode::kDataLoss) << "no robot, no itself";
}

}  // namespace
}  // namespace cwm::cli
