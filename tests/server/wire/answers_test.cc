#include "server/wire/answers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/wire/wire_test_values.h"

namespace cwm::server {
namespace {

using ::testing::ElementsAre;

// A world of objects a, b, c; answers name c twice and a once.
class Answers : public ::testing::Test {
 protected:
  Answers() {
    std::vector<collision::WorldObjectPtr> objects;
    for (const char* name : {"a", "b", "c"}) {
      collision::WorldObject object;
      object.name = name;
      object.uid = std::string("uid_") + name;
      auto model = std::make_shared<HybridModel>();
      for (int part = 0; part < 6; ++part) {
        model->shapes.push_back({.X_OS = Pose::Identity(), .shape = Sphere{0.1}, .fit = {}});
      }
      object.geometry = collision::Prepare(std::move(model));
      objects.push_back(collision::Place(object));
    }
    snapshot_ = collision::WorldSnapshot({9}, objects);
    pairs_.completed = 2;
    pairs_.row_begin = {0, 1, 3};
    pairs_.distance_m = {0.5, -0.25, 1.5};
    pairs_.point_body = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    pairs_.point_object = {1.5, 2, 3, 4, 5, 6, 7, 8, 9};
    pairs_.normal = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    pairs_.object = {2, 0, 2};
    pairs_.body_part = {0, 1, 2};
    pairs_.object_part = {3, 4, 5};
    pairs_.trust = {collision::Trust::kExact, collision::Trust::kBounded, collision::Trust::kExact};
    pairs_.bound_m = {0, 0.125, 0};
  }
  AnswerContext Context(Form form, Precision precision = Precision::kDouble) const {
    return {"uid", snapshot_.revision(), snapshot_, form, precision};
  }

  collision::WorldSnapshot snapshot_;
  collision::PairColumns pairs_;
};

TEST_F(Answers, ColumnsAreTheBytesOfTheAnswer) {
  v1::GetDistancesResponse response;
  ToProto(pairs_, Context(Form::kColumns), &response);
  EXPECT_EQ(response.world_uid(), "uid");
  EXPECT_EQ(response.revision(), 9);
  EXPECT_EQ(response.completed_count(), 2);
  ASSERT_EQ(response.objects_size(), 2);
  EXPECT_EQ(response.objects(0).name(), "a");
  EXPECT_EQ(response.objects(1).uid(), "uid_c");
  const v1::PairColumns& columns = response.columns();
  EXPECT_EQ(columns.scalar(), v1::SCALAR_F64);
  EXPECT_THAT(NumbersIn<std::uint32_t>(columns.row_begin()), ElementsAre(0, 1, 3));
  EXPECT_EQ(NumbersIn<double>(columns.distance_m()), pairs_.distance_m);
  EXPECT_EQ(NumbersIn<double>(columns.point_body()), pairs_.point_body);
  EXPECT_EQ(NumbersIn<double>(columns.point_object()), pairs_.point_object);
  EXPECT_EQ(NumbersIn<double>(columns.normal()), pairs_.normal);
  EXPECT_THAT(NumbersIn<std::int32_t>(columns.object_index()), ElementsAre(1, 0, 1));
  EXPECT_EQ(NumbersIn<std::int32_t>(columns.object_part()), pairs_.object_part);
  EXPECT_EQ(columns.trust(), std::string("\x01\x02\x01"));
  EXPECT_EQ(NumbersIn<double>(columns.bound_m()), pairs_.bound_m);
}

TEST_F(Answers, SinglePrecisionRoundsEachNumberOnce) {
  v1::GetContactsResponse response;
  ToProto(pairs_, Context(Form::kColumns, Precision::kSingle), &response);
  EXPECT_EQ(response.columns().scalar(), v1::SCALAR_F32);
  EXPECT_THAT(NumbersIn<float>(response.columns().distance_m()), ElementsAre(0.5f, -0.25f, 1.5f));
  EXPECT_EQ(response.columns().normal().size(), 9 * sizeof(float));
}

TEST_F(Answers, BoundsAreLeftOutWhereAllIsExact) {
  pairs_.trust.assign(3, collision::Trust::kExact);
  v1::GetDistancesResponse response;
  ToProto(pairs_, Context(Form::kColumns), &response);
  EXPECT_TRUE(response.columns().bound_m().empty());
}

TEST_F(Answers, RowsSayTheSameWithNames) {
  v1::GetDistancesResponse response;
  ToProto(pairs_, Context(Form::kRows), &response);
  EXPECT_FALSE(response.has_columns());
  ASSERT_EQ(response.rows_size(), 2);
  ASSERT_EQ(response.rows(1).answers_size(), 2);
  const v1::PairRow& deep = response.rows(1).answers(0);
  EXPECT_EQ(deep.distance_m(), -0.25);
  EXPECT_EQ(deep.object(), "a");
  EXPECT_EQ(deep.trust(), v1::TRUST_BOUNDED);
  EXPECT_EQ(deep.bound_m(), 0.125);
  EXPECT_EQ(deep.normal().y(), 1);
  EXPECT_FALSE(response.rows(0).answers(0).has_bound_m());
}

TEST_F(Answers, VerdictsNameThePairThatTold) {
  const collision::CollisionColumns answers{
      .verdict = {collision::Verdict::kFree, collision::Verdict::kCollision},
      .object = {-1, 1},
      .body_part = {-1, 0},
      .object_part = {-1, 2},
      .trust = {collision::Trust::kExact, collision::Trust::kExact},
      .completed = 2};
  v1::CheckCollisionsResponse columns;
  ToProto(answers, Context(Form::kColumns), &columns);
  EXPECT_EQ(columns.verdicts(), std::string("\x01\x02"));
  EXPECT_THAT(NumbersIn<std::int32_t>(columns.object_index()), ElementsAre(-1, 0));
  EXPECT_EQ(columns.objects(0).name(), "b");
  v1::CheckCollisionsResponse rows;
  ToProto(answers, Context(Form::kRows), &rows);
  EXPECT_FALSE(rows.rows(0).has_object());
  EXPECT_EQ(rows.rows(1).verdict(), v1::VERDICT_COLLISION);
  EXPECT_EQ(rows.rows(1).object(), "b");
  EXPECT_EQ(rows.rows(1).object_part(), 2);
}

TEST_F(Answers, SamplesBeyondNameNothingAndBoundsComeWhereAPointIsBounded) {
  collision::PointColumns answers{
      .state = {collision::SampleState::kBeyond, collision::SampleState::kSmooth},
      .distance_m = {0, -2},
      .gradient = {0, 0, 0, 0, 0, 1},
      .object = {0, 2},
      .object_part = {0, 1},
      .trust = {collision::Trust::kExact, collision::Trust::kExact},
      .bounds = {},
      .completed = 2};
  v1::SamplePointsResponse exact;
  ToProto(answers, Context(Form::kColumns), &exact);
  ASSERT_EQ(exact.objects_size(), 1);
  EXPECT_EQ(exact.objects(0).name(), "c");
  EXPECT_THAT(NumbersIn<std::int32_t>(exact.object_index()), ElementsAre(-1, 0));
  EXPECT_EQ(exact.bound_m(), "");
  answers.trust[1] = collision::Trust::kBounded;
  answers.bounds = {{.row = 1, .bound_m = 0.5}};
  v1::SamplePointsResponse bounded;
  ToProto(answers, Context(Form::kColumns), &bounded);
  EXPECT_THAT(NumbersIn<double>(bounded.bound_m()), ElementsAre(0, 0.5));
  v1::SamplePointsResponse rows;
  ToProto(answers, Context(Form::kRows), &rows);
  EXPECT_FALSE(rows.rows(0).has_distance_m() || rows.rows(0).has_bound_m());
  EXPECT_EQ(rows.rows(1).bound_m(), 0.5);
  EXPECT_EQ(rows.rows(1).object(), "c");
}

TEST_F(Answers, RaysThatMissNameNothing) {
  const collision::RayColumns answers{.hit = {0, 1},
                                      .distance_m = {0, 2},
                                      .normal = {0, 0, 0, 0, 0, 1},
                                      .object = {0, 2},
                                      .object_part = {0, 1},
                                      .completed = 2};
  const std::vector<collision::RayRow> rays = {{.origin = {0, 0, 5}, .direction = {1, 0, 0}},
                                               {.origin = {0, 0, 5}, .direction = {0, 0, -1}}};
  v1::CastRaysResponse columns;
  ToProto(answers, rays, Context(Form::kColumns), &columns);
  ASSERT_EQ(columns.objects_size(), 1);
  EXPECT_EQ(columns.objects(0).name(), "c");
  EXPECT_THAT(NumbersIn<std::int32_t>(columns.object_index()), ElementsAre(-1, 0));
  v1::CastRaysResponse rows;
  ToProto(answers, rays, Context(Form::kRows), &rows);
  EXPECT_FALSE(rows.rows(0).hit() || rows.rows(0).has_distance_m() || rows.rows(0).has_object());
  EXPECT_EQ(rows.rows(1).point().z(), 3);
  EXPECT_EQ(rows.rows(1).object(), "c");
}

}  // namespace
}  // namespace cwm::server
