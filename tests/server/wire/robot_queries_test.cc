// Robots as subjects of queries, and motions of subjects.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "server/wire/queries.h"
#include "tests/collision/world/test_arm.h"
#include "tests/server/wire/wire_test_values.h"

namespace cwm::server {
namespace {

using collision::testing::Arm;
using collision::testing::ArmSrdf;
using collision::testing::ArmUrdf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// "left" has spheres only for its base; its base is at x = 1 and its elbow at 0.3. "bare" has none.
class RobotSubjects : public ::testing::Test {
 protected:
  RobotSubjects() {
    collision::SphereModel spheres;
    spheres.links.resize(7);
    spheres.links[0] = {{.center_L = {0, 0, 1}, .radius_m = 0.5}, {.radius_m = 0.25}};
    auto left = collision::testing::PutArm("left", Arm(ArmUrdf(), ArmSrdf(), spheres));
    left.X_WB = MakeTranslation(1, 0, 0);
    left.state[0] = 0.3;
    const std::vector<collision::Change> changes = {
        {.what = left, .expected_object_revision = {}},
        {.what = collision::testing::PutArm("bare"), .expected_object_revision = {}}};
    snapshot_ = *collision::Apply(std::make_shared<const collision::WorldSnapshot>(), changes);
    robot_.set_robot("left");
    robot_.set_group("reach");
  }
  absl::StatusOr<StateQuery> Convert() {
    const FieldPath root;
    return RobotQueryFromProto(robot_, {*snapshot_, store_, limits_}, root.Field("robot"));
  }
  absl::StatusOr<RobotRows> States() {
    const auto query = Convert();
    if (!query.ok()) return query.status();
    return std::get<RobotRows>(query->states);
  }
  void SetRows(const std::vector<double>& values) {
    robot_.mutable_rows()->set_data(BytesOf(values));
  }
  void SetBase(const std::string& variable, double value) {
    v1::VariableValue* set = robot_.mutable_base_state()->add_values();
    set->set_variable(variable);
    set->set_value(value);
  }
  void ExpectFault(const std::string& field, const std::string& rule) {
    const absl::Status status = Convert().status();
    EXPECT_EQ(FieldAtFault(status), field) << status;
    EXPECT_THAT(TextOf(status), HasSubstr(rule));
  }

  std::shared_ptr<const collision::WorldSnapshot> snapshot_;
  GeometryStore store_{1 << 20};
  Limits limits_;
  v1::RobotSubject robot_;
};

TEST_F(RobotSubjects, StandWhereTheyAreUnlessTheyAreSaidToBeElsewhere) {
  const auto stored = States();
  ASSERT_TRUE(stored.ok()) << stored.status();
  EXPECT_EQ(stored->X_WB.translation(), Vector3(1, 0, 0));
  EXPECT_THAT(stored->rows, ElementsAre(0.3, 0)) << "no rows: one, as it stands";
  SetBase("slide", 0.2);
  robot_.mutable_x_world_base()->set_ty_m(5);
  robot_.mutable_x_world_base()->set_qw(1);
  const auto said = States();
  ASSERT_TRUE(said.ok()) << said.status();
  EXPECT_EQ(said->X_WB.translation(), Vector3(0, 5, 0));
  EXPECT_THAT(said->rows, ElementsAre(0.3, 0.2));
}

TEST_F(RobotSubjects, HaveRowsOfTheirGroupOverTheirBase) {
  robot_.mutable_base_state()->set_group("reach");
  robot_.mutable_base_state()->set_named_state("ready");
  SetBase("grip", 0.01);
  robot_.mutable_rows()->set_scalar(v1::SCALAR_F32);
  robot_.mutable_rows()->set_data(BytesOf<float>({0.25, 0.125, -0.5, 0.5}));
  const auto query = Convert();
  ASSERT_TRUE(query.ok()) << query.status();
  const auto& states = std::get<RobotRows>(query->states);
  EXPECT_THAT(states.rows, ElementsAre(0.25, 0.125, -0.5, 0.5));
  EXPECT_EQ(states.base[0], 0.5);
  EXPECT_EQ(states.base[2], 0.01);
  const auto rows = RowsOf(*query);
  EXPECT_EQ(rows->size(), 2u);
  std::vector<Pose> X_WL(7);
  rows->Place(1, X_WL);
  EXPECT_EQ(X_WL[0].translation(), Vector3(1, 0, 0));
  EXPECT_THAT(BodyNamesOf(*query).links, ElementsAre("base", "upper", "tip", "tip"));
}

TEST_F(RobotSubjects, HaveEveryVariableWithoutAGroup) {
  robot_.clear_group();
  std::vector<double> rows(20, 0.0);
  rows[9] = rows[19] = 1;  // qw
  SetRows(rows);
  EXPECT_EQ(RowsOf(*Convert())->size(), 2u);
  rows.pop_back();
  SetRows(rows);
  ExpectFault("robot.rows.data",
              "has 152 bytes, must be a multiple of 80 (10 F64 a row, since scalar is not given)");
  robot_.mutable_rows()->set_scalar(v1::SCALAR_F64);
  ExpectFault("robot.rows.data", "has 152 bytes, must be a multiple of 80 (10 F64 a row)");
}

TEST_F(RobotSubjects, HaveUnitQuaternionsOfFloatingJoints) {
  robot_.clear_group();
  std::vector<double> rows(30, 0.0);
  const auto set = [&](double second_qw, double third_qw) {
    rows[9] = 1;
    rows[19] = second_qw;
    rows[29] = third_qw;
    SetRows(rows);
  };
  set(0.9991, 1.0009);
  EXPECT_TRUE(Convert().ok()) << "as poses may be";
  set(1, 1.0011);
  ExpectFault("robot.rows.data row 2",
              "the quaternion of float has length 1.0011, must be 1 within 1e-3");
  set(0, 1);
  ExpectFault("robot.rows.data row 1", "has length 0");
  robot_.mutable_rows()->set_scalar(v1::SCALAR_F32);
  robot_.mutable_rows()->set_data(BytesOf(std::vector<float>(10, 0.0F)));
  ExpectFault("robot.rows.data row 0", "has length 0");
}

TEST_F(RobotSubjects, HaveTheirLinksWhereWorldsHaveRoom) {
  robot_.mutable_x_world_base()->set_tx_m(4e5);
  robot_.mutable_x_world_base()->set_qw(1);
  robot_.mutable_rows()->set_scalar(v1::SCALAR_F64);
  SetRows({0, 0, 0, 5e5});
  EXPECT_TRUE(Convert().ok()) << "outside of its limits alone";
  SetRows({0, 0, 0, -9.9e5});
  EXPECT_TRUE(Convert().ok()) << "to another side";
  SetRows({0, 0, 0, 7e5});
  ExpectFault(
      "robot.rows.data row 1",
      "puts link \"fore\" at (1.1e+06, 0, 0), must be within 1e+06 m of the world's origin");
}

// float(0.0873) is greater than 0.0873, float(0.04) less than 0.04.
TEST_F(RobotSubjects, OfSinglePrecisionAreAtTheLimitThatTheyWereClampedTo) {
  std::string urdf = ArmUrdf();
  const std::string limits = "lower=\"-1\" upper=\"1\"";
  urdf.replace(urdf.find(limits), limits.size(), "lower=\"-0.0873\" upper=\"0.0873\"");
  const std::vector<collision::Change> changes = {
      {.what = collision::testing::PutArm("left", Arm(urdf)), .expected_object_revision = {}}};
  snapshot_ = *collision::Apply(snapshot_, changes);
  const float min = -0.0873F, max = 0.0873F;
  ASSERT_GT(double{max}, 0.0873);
  std::vector<float> rows;
  std::vector<bool> is_inside;
  while (is_inside.size() < 400) {  // enough to fill the SIMD lanes
    for (const float elbow : {max, min, 0.0F, std::nextafter(max, 1.0F), std::nextafter(min, -1.0F),
                              std::nextafter(max, 0.0F)}) {
      rows.insert(rows.end(), {elbow, 0.1F});
      is_inside.push_back(elbow >= min && elbow <= max);
    }
  }
  robot_.mutable_rows()->set_scalar(v1::SCALAR_F32);
  robot_.mutable_rows()->set_data(BytesOf(rows));
  const auto query = Convert();
  ASSERT_TRUE(query.ok()) << query.status();
  EXPECT_EQ(std::get<RobotRows>(query->states).rows[0], 0.0873);
  const auto body_rows = RowsOf(*query);
  const auto in_lanes = *collision::CheckCollisions(*snapshot_, query->body, *body_rows, {});
  for (std::size_t row = 0; row < is_inside.size(); ++row) {
    EXPECT_EQ(body_rows->IsWithinLimits(row), is_inside[row]) << row;
    EXPECT_EQ(in_lanes.verdict[row] != collision::Verdict::kOutOfLimits, is_inside[row]) << row;
  }
  const std::vector<double> doubles(rows.begin(), rows.end());
  robot_.mutable_rows()->set_scalar(v1::SCALAR_F64);
  robot_.mutable_rows()->set_data(BytesOf(doubles));
  EXPECT_FALSE(RowsOf(*Convert())->IsWithinLimits(0)) << "double precision needs no such leave";
}

TEST_F(RobotSubjects, OutliveTheWorldThatTheyAreOf) {
  SetRows({0.1, 0.2});
  const auto query = Convert();
  ASSERT_TRUE(query.ok());
  snapshot_.reset();
  std::vector<Pose> X_WL(7);
  RowsOf(*query)->Place(0, X_WL);
  EXPECT_TRUE(RowsOf(*query)->IsWithinLimits(0));
}

TEST_F(RobotSubjects, AreAskedForAScope) {
  robot_.set_scope(v1::ROBOT_SCOPE_WORLD);
  EXPECT_TRUE(Convert()->body.self_pairs.empty());
  robot_.set_scope(v1::ROBOT_SCOPE_SELF);
  EXPECT_FALSE(Convert()->body.tests_world);
  robot_.set_scope(v1::ROBOT_SCOPE_UNSPECIFIED);
  EXPECT_TRUE(Convert()->body.tests_world);
  EXPECT_FALSE(Convert()->body.self_pairs.empty());
  robot_.set_scope(static_cast<v1::RobotScope>(9));
  ExpectFault("robot.scope", "is 9");
}

TEST_F(RobotSubjects, AreOfSpheresWhereTheyHaveSome) {
  robot_.set_robot_geometry(v1::ROBOT_GEOMETRY_SPHERES_AS_GIVEN);
  const auto query = Convert();
  ASSERT_TRUE(query.ok()) << query.status();
  EXPECT_THAT(BodyNamesOf(*query).links, ElementsAre("base", "base"));
  EXPECT_EQ(query->body.best_accuracy, collision::Accuracy::kDegraded);
  robot_.set_robot("bare");
  const absl::Status none = Convert().status();
  EXPECT_EQ(none.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(DetailsOf(none).reason, "NO_SPHERES");
  EXPECT_THAT(TextOf(none), HasSubstr("robot.robot_geometry: robot \"bare\" was loaded without"));
  robot_.set_robot_geometry(v1::ROBOT_GEOMETRY_SPHERES_CONTAINING);
  EXPECT_TRUE(Convert().ok()) << "they are fitted to its links";
  robot_.set_robot_geometry(static_cast<v1::RobotGeometry>(9));
  ExpectFault("robot.robot_geometry", "is 9");
}

TEST_F(RobotSubjects, UnknownOnesAreNotFound) {
  robot_.set_robot("ghost");
  EXPECT_TRUE(absl::IsNotFound(Convert().status()));
  EXPECT_EQ(DetailsOf(Convert().status()).reason, "ROBOT_UNKNOWN");
  robot_.set_robot("no such/ name!");
  ExpectFault("robot.robot", "");
}

TEST_F(RobotSubjects, FaultsAreNamed) {
  robot_.set_group("arm");
  ExpectFault("robot.group", "is \"arm\", must be empty, for all variables, or one of \"reach\"");
  robot_.set_group("reach");
  SetRows({0, 0, 0, std::numeric_limits<double>::quiet_NaN()});
  ExpectFault("robot.rows.data row 1", "slide is nan, must be finite");
  SetRows({0, 0, 1e7, 0});
  ExpectFault("robot.rows.data row 1", "elbow is 1e+07");
  robot_.mutable_rows()->set_data("abc");
  ExpectFault("robot.rows.data", "has 3 bytes, must be a multiple of 16 (2 F64 a row, since");
  robot_.mutable_rows()->set_scalar(static_cast<v1::Scalar>(7));
  ExpectFault("robot.rows.scalar", "is 7");
  SetRows(std::vector<double>(6, 0.0));  // three rows of two values, declared as two rows of three
  robot_.mutable_rows()->set_scalar(v1::SCALAR_F64);
  robot_.mutable_rows()->set_width(3);
  ExpectFault("robot.rows.width",
              "is 3, must be 2, one for each variable of the group: elbow slide");
  robot_.mutable_rows()->set_width(-2);
  ExpectFault("robot.rows.width", "is -2, must be 2");
  robot_.mutable_rows()->set_width(2);
  EXPECT_TRUE(Convert().ok());
  robot_.clear_rows();
  limits_.max_batch_rows = 2;
  SetRows(std::vector<double>(6, 0.0));
  ExpectFault("robot.rows.data", "has 3 rows, must have at most 2");
  robot_.clear_rows();
  robot_.mutable_x_world_base()->set_qw(2);
  ExpectFault("robot.x_world_base.qx..qw", "has length 2");
  robot_.clear_x_world_base();
  SetBase("bolt", 0.1);
  ExpectFault("robot.base_state.values[0].value", "joint \"bolt\" is fixed");
  robot_.mutable_base_state()->mutable_values(0)->set_variable("other");
  ExpectFault("robot.base_state.values[0].value", "joint \"other\" mimics another");
  robot_.mutable_base_state()->mutable_values(0)->set_variable("nose");
  ExpectFault("robot.base_state.values[0].variable", "is \"nose\", must be a variable");
}

TEST_F(RobotSubjects, AreRefusedWhereARowWouldTakeLong) {
  const auto load = [&](std::size_t of_base, std::size_t of_tip) {
    collision::SphereModel spheres;
    spheres.links.resize(7);
    const auto arm = Arm();
    spheres.links[0].resize(of_base, {.radius_m = 0.1});
    spheres.links[static_cast<std::size_t>(*arm->model->FindLink("tip"))].resize(of_tip,
                                                                                 {.radius_m = 0.1});
    const std::vector<collision::Change> changes = {
        {.what = collision::testing::PutArm("left", Arm(ArmUrdf(), ArmSrdf(), spheres)),
         .expected_object_revision = {}}};
    snapshot_ = *collision::Apply(snapshot_, changes);
  };
  robot_.set_robot_geometry(v1::ROBOT_GEOMETRY_SPHERES_AS_GIVEN);
  load(1'000, 1'000);
  EXPECT_TRUE(Convert().ok()) << Convert().status();
  EXPECT_EQ(Convert()->body.self_pairs.size(), 1'000'000u);
  load(1'000, 1'001);
  ExpectFault("robot.scope", "asks about 1001000 pairs of the robot's own parts, must be");
  robot_.set_scope(v1::ROBOT_SCOPE_WORLD);
  EXPECT_TRUE(Convert().ok());
  load(0, 4'097);
  ExpectFault("robot.robot_geometry", "has 4097 parts, must have at most 4096");
}

class MotionRequests : public RobotSubjects {
 protected:
  absl::StatusOr<MotionQuery> ConvertMotions() {
    if (request_.subject().what_case() == v1::Subject::WHAT_NOT_SET) {
      *request_.mutable_subject()->mutable_robot() = robot_;
    }
    return MotionQueryFromProto(request_, QuerySource{*snapshot_, store_, limits_});
  }
  void ExpectMotionFault(const std::string& field, const std::string& rule) {
    const absl::Status status = ConvertMotions().status();
    EXPECT_EQ(FieldAtFault(status), field) << status;
    EXPECT_THAT(TextOf(status), HasSubstr(rule));
    request_.clear_subject();
  }
  v1::CheckMotionsRequest request_;
};

TEST_F(MotionRequests, AreOfPairsOfRowsOrOfPaths) {
  SetRows(std::vector<double>(12, 0.0));
  const auto pairs = ConvertMotions();
  ASSERT_TRUE(pairs.ok()) << pairs.status();
  ASSERT_EQ(pairs->paths.size(), 3u);
  EXPECT_EQ(pairs->paths[2].first_row, 4u);
  EXPECT_EQ(pairs->paths[2].row_count, 2u);
  request_.add_path_row_counts(4);
  request_.add_path_row_counts(2);
  const auto paths = ConvertMotions();
  ASSERT_TRUE(paths.ok()) << paths.status();
  ASSERT_EQ(paths->paths.size(), 2u);
  EXPECT_EQ(paths->paths[0].row_count, 4u);
  EXPECT_EQ(paths->paths[1].first_row, 4u);
}

TEST_F(MotionRequests, RefuseRowsThatMakeNoPaths) {
  SetRows(std::vector<double>(6, 0.0));
  ExpectMotionFault("subject", "has 3 rows, must have an even number");
  request_.add_path_row_counts(2);
  ExpectMotionFault("path_row_counts", "add up to 2, must add up to the 3 rows");
  request_.add_path_row_counts(2'000'000'000);
  ExpectMotionFault("path_row_counts", "add up to more, must add up to the 3 rows");
  request_.set_path_row_counts(1, 1);
  ExpectMotionFault("path_row_counts[1]", "is 1, must be at least 2");
  request_.set_path_row_counts(1, -2'000'000'000);
  ExpectMotionFault("path_row_counts[1]", "must be at least 2");
}

TEST_F(MotionRequests, RefusePoints) {
  request_.mutable_subject()->mutable_points()->set_data(BytesOf<double>({0, 0, 0, 1, 1, 1}));
  ExpectMotionFault("subject.points", "must be one of shapes, object, robot");
}

TEST_F(MotionRequests, MoveFloatingJoints) {
  robot_.clear_group();
  std::vector<double> rows(20, 0.0);
  rows[9] = rows[18] = 1;  // first not turned, then turned by half a turn about z
  rows[10 + 3] = 0.5;
  SetRows(rows);
  const auto motion = ConvertMotions();
  ASSERT_TRUE(motion.ok()) << motion.status();
  EXPECT_EQ(RowsOf(motion->query)->size(), 2u);
}

}  // namespace
}  // namespace cwm::server
