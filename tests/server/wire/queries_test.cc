#include "server/wire/queries.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "server/wire/poses.h"
#include "server/wire/times.h"
#include "tests/server/wire/wire_test_values.h"

namespace cwm::server {
namespace {

absl::StatusOr<ParsedQueryOptions> ConvertOptions(const v1::QueryOptions& options) {
  const FieldPath root;
  return QueryOptionsFromProto(options, root.Field("options"));
}

TEST(QueryOptions, HaveTheDocumentedDefaults) {
  const auto options = ConvertOptions({});
  ASSERT_TRUE(options.ok());
  EXPECT_TRUE(std::holds_alternative<Latest>(options->at_revision));
  EXPECT_EQ(options->query.engine, collision::EngineChoice::kAuto);
  EXPECT_EQ(options->query.representation, collision::Representation::kHybrid);
  EXPECT_EQ(options->query.unseen, collision::UnseenSpace::kBlock);
  EXPECT_EQ(options->query.max_results, 1);
  EXPECT_EQ(options->query.max_contacts, 16);
  EXPECT_EQ(options->query.max_distance_m, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(options->time_budget.has_value());
  EXPECT_EQ(options->form, Form::kColumns);
  EXPECT_EQ(options->precision, Precision::kDouble);
}

TEST(QueryOptions, KeepWhatIsGiven) {
  v1::QueryOptions proto;
  proto.mutable_at_revision()->set_exact(7);
  proto.set_engine(v1::ENGINE_BULLET);
  proto.set_representation(v1::REPRESENTATION_SURFACES);
  proto.set_unseen(v1::UNSEEN_SPACE_REPORT);
  proto.set_margin_m(0.02);
  proto.set_max_distance_m(0);
  proto.set_max_results(64);
  proto.add_ignore("table");
  proto.mutable_time_budget()->set_nanos(5'000'000);
  proto.set_scalar(v1::SCALAR_F32);
  proto.set_result_form(v1::RESULT_FORM_ROWS);
  const auto options = ConvertOptions(proto);
  ASSERT_TRUE(options.ok()) << options.status();
  EXPECT_EQ(std::get<Exactly>(options->at_revision).revision.value, 7);
  EXPECT_EQ(options->query.engine, collision::EngineChoice::kBullet);
  EXPECT_EQ(options->query.unseen, collision::UnseenSpace::kReport);
  EXPECT_EQ(options->query.max_distance_m, 0);
  EXPECT_EQ(options->query.ignore, std::vector<std::string>{"table"});
  EXPECT_EQ(options->time_budget, std::chrono::milliseconds(5));
  EXPECT_EQ(options->precision, Precision::kSingle);
  EXPECT_EQ(options->form, Form::kRows);
}

TEST(QueryOptions, FaultsAreNamed) {
  struct Case {
    std::function<void(v1::QueryOptions&)> spoil;
    std::string field;
  };
  for (const Case& c : std::vector<Case>{
           {[](auto& o) { o.mutable_at_revision()->set_exact(-1); }, "options.at_revision.exact"},
           {[](auto& o) { o.mutable_at_revision()->set_at_least(-1); },
            "options.at_revision.at_least"},
           {[](auto& o) { o.set_engine(static_cast<v1::Engine>(77)); }, "options.engine"},
           {[](auto& o) { o.set_representation(static_cast<v1::Representation>(77)); },
            "options.representation"},
           {[](auto& o) { o.set_unseen(static_cast<v1::UnseenSpace>(9)); }, "options.unseen"},
           {[](auto& o) { o.set_margin_m(kNan); }, "options.margin_m"},
           {[](auto& o) { o.set_margin_m(-1); }, "options.margin_m"},
           {[](auto& o) { o.set_max_distance_m(-1); }, "options.max_distance_m"},
           {[](auto& o) { o.set_max_results(65); }, "options.max_results"},
           {[](auto& o) { o.set_max_results(-1); }, "options.max_results"},
           {[](auto& o) { o.set_max_contacts(1'025); }, "options.max_contacts"},
           {[](auto& o) { o.mutable_time_budget(); }, "options.time_budget"},
           {[](auto& o) { o.set_result_form(static_cast<v1::ResultForm>(7)); },
            "options.result_form"},
           {[](auto& o) { o.set_scalar(static_cast<v1::Scalar>(7)); }, "options.scalar"}}) {
    v1::QueryOptions options;
    c.spoil(options);
    EXPECT_EQ(FieldAtFault(ConvertOptions(options).status()), c.field)
        << ConvertOptions(options).status();
  }
}

const std::vector<Pose>& PosesOf(const StateQuery& query) {
  return std::get<std::vector<Pose>>(query.states);
}

class Subjects : public ::testing::Test {
 protected:
  Subjects() {
    auto model = std::make_shared<HybridModel>();
    model->shapes.push_back({.X_OS = Pose::Identity(), .shape = Sphere{0.1}, .fit = {}});
    collision::WorldObject object;
    object.name = "ball";
    object.X_WO = MakeTranslation(1, 2, 3);
    object.geometry = collision::Prepare(std::move(model));
    const collision::WorldObjectPtr objects[] = {collision::Place(object)};
    snapshot_ = collision::WorldSnapshot({1}, objects);
  }
  absl::StatusOr<StateQuery> ConvertOptions(const v1::Subject& subject) {
    return StateQueryFromProto(subject, {snapshot_, store_, limits_}, {});
  }

  collision::WorldSnapshot snapshot_;
  GeometryStore store_{1 << 20};
  Limits limits_;
};

TEST_F(Subjects, ShapesAtPoses) {
  v1::Subject subject;
  subject.mutable_shapes()->add_shapes()->mutable_sphere()->set_radius_m(0.1);
  subject.mutable_shapes()->mutable_x_world_body()->set_data(
      BytesOf<double>({1, 0, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 0, 1}));
  const auto query = ConvertOptions(subject);
  ASSERT_TRUE(query.ok()) << query.status();
  EXPECT_EQ(PosesOf(*query).size(), 2u);
  EXPECT_EQ(query->body.geometry->parts.size(), 1u);
  EXPECT_TRUE(query->body.self.empty());
  subject.mutable_shapes()->clear_shapes();
  EXPECT_EQ(FieldAtFault(ConvertOptions(subject).status()), "shapes.shapes");
}

TEST_F(Subjects, AWorldObjectStandsWhereItIsUnlessPosesAreGiven) {
  v1::Subject subject;
  subject.mutable_object()->set_name("ball");
  const auto stored = ConvertOptions(subject);
  ASSERT_TRUE(stored.ok());
  ASSERT_EQ(PosesOf(*stored).size(), 1u);
  EXPECT_EQ(PosesOf(*stored)[0].translation(), Vector3(1, 2, 3));
  EXPECT_EQ(stored->body.self, "ball");
  subject.mutable_object()->mutable_x_world_object()->set_data(
      BytesOf<double>({9, 0, 0, 0, 0, 0, 1}));
  const auto given = ConvertOptions(subject);
  ASSERT_TRUE(given.ok());
  EXPECT_EQ(PosesOf(*given)[0].translation(), Vector3(9, 0, 0));
}

TEST_F(Subjects, AnUnknownObjectIsNotFound) {
  v1::Subject subject;
  subject.mutable_object()->set_name("ghost");
  const auto status = ConvertOptions(subject).status();
  EXPECT_TRUE(absl::IsNotFound(status));
  EXPECT_EQ(DetailsOf(status).reason, "OBJECT_UNKNOWN");
  EXPECT_EQ(DetailsOf(status).metadata.at("object"), "ghost");
}

TEST_F(Subjects, PointsAndNothing) {
  v1::Subject subject;
  EXPECT_EQ(FieldAtFault(ConvertOptions(subject).status()), "what");
  subject.mutable_points()->set_scalar(v1::SCALAR_F32);
  subject.mutable_points()->set_data(BytesOf<float>({1, 2, 3}));
  const auto query = ConvertOptions(subject);
  ASSERT_TRUE(query.ok());
  EXPECT_EQ(PosesOf(*query)[0].translation(), Vector3(1, 2, 3));
}

TEST_F(Subjects, RowsAreForFewRows) {
  EXPECT_TRUE(CheckForm(Form::kRows, 1'024, limits_).ok());
  EXPECT_EQ(FieldAtFault(CheckForm(Form::kRows, 1'025, limits_)), "options.result_form");
  EXPECT_TRUE(CheckForm(Form::kColumns, 1'025, limits_).ok());
}

// Every row of the largest batch may have the default number of contacts, but not one more.
TEST_F(Subjects, ABatchHasALimitOfAnswersThatTheErrorNames) {
  EXPECT_TRUE(CheckAnswers({"options.max_contacts", 16, 65'536}, Form::kColumns, limits_).ok());
  const auto refused = CheckAnswers({"options.max_contacts", 17, 65'536}, Form::kColumns, limits_);
  EXPECT_EQ(FieldAtFault(refused), "options.max_contacts");
  EXPECT_EQ(refused.message(),
            "options.max_contacts: is 17 for 65536 rows, must be at most 16: a batch has at most "
            "1048576 answers");
  EXPECT_TRUE(CheckAnswers({"options.max_results", 64, 1'024}, Form::kRows, limits_).ok());
  EXPECT_FALSE(CheckAnswers({"options.max_results", 65, 1'024}, Form::kRows, limits_).ok());
  EXPECT_TRUE(CheckAnswers({"options.max_contacts", 1'024, 0}, Form::kColumns, limits_).ok());
}

TEST(WireTime, SurvivesARoundTripAlsoBefore1970) {
  for (const std::int64_t nanos : {0LL, 1LL, -1LL, 1'700'000'000'123'456'789LL, -5'000'000'001LL}) {
    const std::chrono::system_clock::time_point time{std::chrono::nanoseconds(nanos)};
    const auto proto = TimePointToProto(time);
    EXPECT_GE(proto.nanos(), 0);
    const auto back = TimePointFromProto(proto, {});
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(*back, time);
  }
  google::protobuf::Timestamp far;
  far.set_seconds(std::numeric_limits<std::int64_t>::min());
  EXPECT_FALSE(TimePointFromProto(far, {}).ok());
}

}  // namespace
}  // namespace cwm::server
