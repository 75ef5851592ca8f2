#include "server/wire/answers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/wire/wire_test_values.h"

namespace cwm::server {
namespace {

using ::testing::ElementsAre;

// A world of objects a, b, c; the answers name c twice and a once.
class Answers : public ::testing::Test {
 protected:
  Answers() {
    std::vector<collision::WorldObjectPtr> objects;
    for (const char* name : {"a", "b", "c"}) {
      collision::WorldObject object;
      object.name = name;
      object.create_revision = {2};
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
    pairs_.accuracy = {collision::Accuracy::kExact, collision::Accuracy::kBounded,
                       collision::Accuracy::kExact};
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
  DistanceAnswersToProto(pairs_, Context(Form::kColumns), &response);
  EXPECT_EQ(response.world_uid(), "uid");
  EXPECT_EQ(response.revision(), 9);
  EXPECT_EQ(response.completed_count(), 2);
  ASSERT_EQ(response.objects_size(), 2);
  EXPECT_EQ(response.objects(0).name(), "a");
  EXPECT_EQ(response.objects(1).uid(), "c@2");
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
  ContactAnswersToProto(pairs_, Context(Form::kColumns, Precision::kSingle), &response);
  EXPECT_EQ(response.columns().scalar(), v1::SCALAR_F32);
  EXPECT_THAT(NumbersIn<float>(response.columns().distance_m()), ElementsAre(0.5f, -0.25f, 1.5f));
  EXPECT_EQ(response.columns().normal().size(), 9 * sizeof(float));
}

TEST_F(Answers, BoundsAreLeftOutWhereAllIsExact) {
  pairs_.accuracy.assign(3, collision::Accuracy::kExact);
  v1::GetDistancesResponse response;
  DistanceAnswersToProto(pairs_, Context(Form::kColumns), &response);
  EXPECT_TRUE(response.columns().bound_m().empty());
}

TEST_F(Answers, BoundsAreOfWhatIsBoundedOrASurfaceAlone) {
  pairs_.accuracy = {collision::Accuracy::kExact, collision::Accuracy::kSurfaceOnly,
                     collision::Accuracy::kDegraded};
  pairs_.bound_m = {1e-9, 0.1, 0.5};  // for a degraded answer, of the part that an engine computed
  for (const Precision precision : {Precision::kDouble, Precision::kSingle}) {
    v1::GetDistancesResponse columns;
    DistanceAnswersToProto(pairs_, Context(Form::kColumns, precision), &columns);
    const std::string& bytes = columns.columns().bound_m();
    std::vector<double> bounds;
    if (precision == Precision::kSingle) {
      const auto single = NumbersIn<float>(bytes);
      bounds.assign(single.begin(), single.end());
    } else {
      bounds = NumbersIn<double>(bytes);
    }
    ASSERT_EQ(bounds.size(), 3u);
    EXPECT_EQ(bounds[0], 0);
    EXPECT_GE(bounds[1], 0.1) << "not rounded down";
    EXPECT_FLOAT_EQ(static_cast<float>(bounds[1]), 0.1F);
    EXPECT_TRUE(std::isnan(bounds[2]));
  }
  v1::GetDistancesResponse rows;
  DistanceAnswersToProto(pairs_, Context(Form::kRows), &rows);
  EXPECT_FALSE(rows.rows(0).answers(0).has_bound_m());
  EXPECT_EQ(rows.rows(1).answers(0).bound_m(), 0.1);
  EXPECT_FALSE(rows.rows(1).answers(1).has_bound_m());
}

TEST_F(Answers, RowsSayTheSameWithNames) {
  v1::GetDistancesResponse response;
  DistanceAnswersToProto(pairs_, Context(Form::kRows), &response);
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
      .accuracy = {collision::Accuracy::kExact, collision::Accuracy::kExact},
      .completed = 2};
  v1::CheckCollisionsResponse columns;
  CollisionAnswersToProto(answers, Context(Form::kColumns), &columns);
  EXPECT_EQ(columns.verdicts(), std::string("\x01\x02"));
  EXPECT_THAT(NumbersIn<std::int32_t>(columns.object_index()), ElementsAre(-1, 0));
  EXPECT_EQ(columns.objects(0).name(), "b");
  v1::CheckCollisionsResponse rows;
  CollisionAnswersToProto(answers, Context(Form::kRows), &rows);
  EXPECT_FALSE(rows.rows(0).has_object());
  EXPECT_EQ(rows.rows(1).verdict(), v1::VERDICT_COLLISION);
  EXPECT_EQ(rows.rows(1).object(), "b");
  EXPECT_EQ(rows.rows(1).object_part(), 2);
}

// The time was over: nothing is known of later rows, and they claim no accuracy.
TEST_F(Answers, RowsThatAreNotComputedHaveNoTrust) {
  const collision::CollisionColumns answers{
      .verdict = {collision::Verdict::kFree, collision::Verdict::kNotComputed},
      .object = {-1, -1},
      .body_part = {-1, -1},
      .object_part = {-1, -1},
      .accuracy = {collision::Accuracy::kExact, collision::Accuracy::kDegraded},
      .completed = 1};
  v1::CheckCollisionsResponse columns;
  CollisionAnswersToProto(answers, Context(Form::kColumns), &columns);
  EXPECT_EQ(columns.verdicts(), std::string("\x01\x05"));
  EXPECT_EQ(columns.trust(), std::string("\x01\x00", 2));
  v1::CheckCollisionsResponse rows;
  CollisionAnswersToProto(answers, Context(Form::kRows), &rows);
  ASSERT_EQ(rows.rows_size(), 1);
  EXPECT_EQ(rows.rows(0).trust(), v1::TRUST_EXACT);
}

TEST_F(Answers, SamplesBeyondNameNothingAndBoundsComeWhereAPointIsBounded) {
  collision::PointColumns answers{
      .state = {collision::SampleState::kBeyond, collision::SampleState::kSmooth},
      .distance_m = {0, -2},
      .gradient = {0, 0, 0, 0, 0, 1},
      .object = {0, 2},
      .object_part = {0, 1},
      .accuracy = {collision::Accuracy::kExact, collision::Accuracy::kExact},
      .bounds = {},
      .completed = 2};
  v1::SamplePointsResponse exact;
  SampleAnswersToProto(answers, Context(Form::kColumns), &exact);
  ASSERT_EQ(exact.objects_size(), 1);
  EXPECT_EQ(exact.objects(0).name(), "c");
  EXPECT_THAT(NumbersIn<std::int32_t>(exact.object_index()), ElementsAre(-1, 0));
  EXPECT_EQ(exact.bound_m(), "");
  answers.accuracy[1] = collision::Accuracy::kBounded;
  answers.bounds = {{.row = 1, .bound_m = 0.5}};
  v1::SamplePointsResponse bounded;
  SampleAnswersToProto(answers, Context(Form::kColumns), &bounded);
  EXPECT_THAT(NumbersIn<double>(bounded.bound_m()), ElementsAre(0, 0.5));
  v1::SamplePointsResponse rows;
  SampleAnswersToProto(answers, Context(Form::kRows), &rows);
  EXPECT_FALSE(rows.rows(0).has_distance_m() || rows.rows(0).has_bound_m());
  EXPECT_EQ(rows.rows(1).bound_m(), 0.5);
  EXPECT_EQ(rows.rows(1).object(), "c");
}

// Link 0 touches object c, and then link 2 of the robot itself.
TEST_F(Answers, OfARobotNameItsLinks) {
  AnswerContext context = Context(Form::kColumns);
  context.body.links = {"base", "arm", "hand"};
  pairs_.object = {2, 0, collision::kSelfObject};
  pairs_.body_part = {0, 1, 0};
  pairs_.object_part = {3, 4, 2};
  v1::GetDistancesResponse columns;
  DistanceAnswersToProto(pairs_, context, &columns);
  EXPECT_THAT(columns.body_links(), ElementsAre("base", "arm", "hand"));
  EXPECT_EQ(columns.objects_size(), 2);
  EXPECT_THAT(NumbersIn<std::int32_t>(columns.columns().object_index()), ElementsAre(1, 0, -2));
  context.form = Form::kRows;
  v1::GetDistancesResponse rows;
  DistanceAnswersToProto(pairs_, context, &rows);
  EXPECT_EQ(rows.rows(0).answers(0).object(), "c");
  EXPECT_EQ(rows.rows(0).answers(0).body_link(), "base");
  EXPECT_FALSE(rows.rows(0).answers(0).has_object_link());
  const v1::PairRow& itself = rows.rows(1).answers(1);
  EXPECT_EQ(itself.object(), "");
  EXPECT_EQ(itself.body_link(), "base");
  EXPECT_EQ(itself.object_link(), "hand");
  const collision::CollisionColumns verdicts{.verdict = {collision::Verdict::kCollision},
                                             .object = {collision::kSelfObject},
                                             .body_part = {1},
                                             .object_part = {2},
                                             .accuracy = {collision::Accuracy::kDegraded},
                                             .completed = 1};
  v1::CheckCollisionsResponse checked;
  CollisionAnswersToProto(verdicts, context, &checked);
  EXPECT_FALSE(checked.rows(0).has_object());
  EXPECT_EQ(checked.rows(0).body_link(), "arm");
  EXPECT_EQ(checked.rows(0).object_link(), "hand");
  EXPECT_EQ(checked.rows(0).trust(), v1::TRUST_DEGRADED);
}

class MotionAnswers : public Answers {
 protected:
  MotionAnswers() {
    using collision::kSelfObject;
    using collision::MotionVerdict;
    for (const collision::MotionResult& answer : std::vector<collision::MotionResult>{
             {.verdict = MotionVerdict::kFree,
           .lo = 0,
           .hi = 1,
           .clearance_m = 0.1 / 7,
           .accuracy = collision::Accuracy::kSurfaceOnly},
             {.verdict = MotionVerdict::kContact,
             .segment = 3,
             .lo = 0.1,
             .hi = 0.7,
             .object = 2,
             .body_part = 1,
             .object_part = 5,
             .accuracy = collision::Accuracy::kBounded},
             {.verdict = MotionVerdict::kContact,
             .segment = 0,
             .lo = 0.7,
             .hi = 0.9,
             .object = kSelfObject,
             .body_part = 0,
             .object_part = 1},
             {.verdict = MotionVerdict::kGrazing, .segment = 1, .lo = 0.3, .hi = 0.4},
             {.verdict = MotionVerdict::kUndecided, .segment = 2, .lo = 0.5, .hi = 0.6},
             {.verdict = MotionVerdict::kOutOfLimits,
             .segment = 4,
             .accuracy = collision::Accuracy::kDegraded}}) {
      Append(motions_, answer);
      ++motions_.completed;
    }
    Append(motions_, {});  // not computed
  }
  collision::MotionColumns motions_;
};

TEST_F(MotionAnswers, ColumnsAreTheBytesOfTheAnswer) {
  v1::CheckMotionsResponse columns;
  MotionAnswersToProto(motions_, Context(Form::kColumns), &columns);
  EXPECT_EQ(columns.completed_count(), 6);
  EXPECT_EQ(columns.verdicts(), "\x01\x02\x02\x03\x04\x06\x05");
  EXPECT_EQ(columns.trust(), "\x03\x02\x01\x01\x01\x04\x01");
  EXPECT_EQ(columns.scalar(), v1::SCALAR_F64);
  EXPECT_EQ(columns.segment(), BytesOf(motions_.segment));
  EXPECT_EQ(columns.lo(), BytesOf(motions_.lo));
  EXPECT_EQ(columns.hi(), BytesOf(motions_.hi));
  EXPECT_EQ(columns.clearance_m(), BytesOf(motions_.clearance_m));
  ASSERT_EQ(columns.objects_size(), 1);
  EXPECT_EQ(columns.objects(0).name(), "c");
  EXPECT_THAT(NumbersIn<std::int32_t>(columns.object_index()),
              ElementsAre(-1, 0, -2, -1, -1, -1, -1));
  EXPECT_EQ(columns.body_part(), BytesOf(motions_.body_part));
}

// As floats 0.1 / 7 and 0.7 are smaller, 0.1 and 0.3 larger than as doubles; bounds stay bounds.
TEST_F(MotionAnswers, SinglePrecisionKeepsBoundsBounds) {
  v1::CheckMotionsResponse columns;
  MotionAnswersToProto(motions_, Context(Form::kColumns, Precision::kSingle), &columns);
  EXPECT_EQ(columns.scalar(), v1::SCALAR_F32);
  const auto lo = NumbersIn<float>(columns.lo()), hi = NumbersIn<float>(columns.hi()),
             clearance = NumbersIn<float>(columns.clearance_m());
  ASSERT_EQ(lo.size(), motions_.lo.size());
  for (std::size_t i = 0; i < lo.size(); ++i) {
    EXPECT_LE(lo[i], motions_.lo[i]);
    EXPECT_GE(hi[i], motions_.hi[i]);
    EXPECT_LE(clearance[i], motions_.clearance_m[i]);
    EXPECT_NEAR(lo[i], motions_.lo[i], 1e-7);
    EXPECT_NEAR(hi[i], motions_.hi[i], 1e-7);
  }
  EXPECT_EQ(hi[0], 1.0f);
}

TEST_F(MotionAnswers, RowsSayWhatTheirVerdictKnows) {
  AnswerContext context = Context(Form::kRows);
  context.body.links = {"arm", "hand"};
  v1::CheckMotionsResponse response;
  MotionAnswersToProto(motions_, context, &response);
  ASSERT_EQ(response.rows_size(), 6);
  const v1::MotionRow& free = response.rows(0);
  EXPECT_TRUE(free.has_clearance_m());
  EXPECT_FALSE(free.has_segment() || free.has_lo() || free.has_hi() || free.has_object());
  const v1::MotionRow& contact = response.rows(1);
  EXPECT_EQ(contact.segment(), 3);
  EXPECT_EQ(contact.lo(), 0.1);
  EXPECT_EQ(contact.object(), "c");
  EXPECT_EQ(contact.body_link(), "hand");
  EXPECT_EQ(contact.object_part(), 5);
  EXPECT_FALSE(contact.has_clearance_m() || contact.has_object_link());
  EXPECT_EQ(free.trust(), v1::TRUST_SURFACE_ONLY);
  EXPECT_EQ(contact.trust(), v1::TRUST_BOUNDED);
  EXPECT_EQ(response.rows(2).trust(), v1::TRUST_EXACT);
  EXPECT_FALSE(response.rows(2).has_object());
  EXPECT_EQ(response.rows(2).object_link(), "hand");
  EXPECT_FALSE(response.rows(3).has_body_part());
  EXPECT_EQ(response.rows(5).verdict(), v1::MOTION_VERDICT_OUT_OF_LIMITS);
  EXPECT_EQ(response.rows(5).segment(), 4);
  EXPECT_EQ(response.rows(5).trust(), v1::TRUST_DEGRADED);
  EXPECT_FALSE(response.rows(5).has_lo());
}

TEST_F(Answers, RaysThatMissNameNothing) {
  const collision::RayColumns answers{
      .hit = {0, 1},
      .distance_m = {0, 2},
      .normal = {0, 0, 0, 0, 0, 1},
      .object = {0, 2},
      .object_part = {0, 1},
      .accuracy = {collision::Accuracy::kBounded, collision::Accuracy::kExact},
      .completed = 2};
  const std::vector<collision::RayRow> rays = {{.origin = {0, 0, 5}, .direction = {1, 0, 0}},
                                               {.origin = {0, 0, 5}, .direction = {0, 0, -1}}};
  v1::CastRaysResponse columns;
  RayAnswersToProto(answers, rays, Context(Form::kColumns), &columns);
  ASSERT_EQ(columns.objects_size(), 1);
  EXPECT_EQ(columns.objects(0).name(), "c");
  EXPECT_THAT(NumbersIn<std::int32_t>(columns.object_index()), ElementsAre(-1, 0));
  EXPECT_EQ(columns.trust()[0], v1::TRUST_BOUNDED) << "of a ray that passes hidden space";
  v1::CastRaysResponse rows;
  RayAnswersToProto(answers, rays, Context(Form::kRows), &rows);
  EXPECT_FALSE(rows.rows(0).hit() || rows.rows(0).has_distance_m() || rows.rows(0).has_object());
  EXPECT_EQ(rows.rows(1).point().z(), 3);
  EXPECT_EQ(rows.rows(1).object(), "c");
}

}  // namespace
}  // namespace cwm::server
