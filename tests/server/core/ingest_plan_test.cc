// Plans from hand-made associations: given the tracker's decisions, the plan is checked.
#include "server/core/ingest_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "tests/collision/world/test_arm.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::ObjectKind;
using collision::ObjectState;
using collision::Owner;
using collision::PutObject;
using collision::testing::PutArm;
using perception::Association;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Outcome = Association::Outcome;

PutObject Perceived(const std::string& name, ObjectKind kind, const std::string& supported_by) {
  return {.name = name,
          .kind = kind,
          .owner = Owner::kPerception,
          .X_WO = Pose::Identity(),
          .geometry = SharedBox(),
          .supported_by = supported_by,
          .margin_m = 0};
}

class IngestPlanTest : public ::testing::Test {
 protected:
  // Objects are ordered by name, so an association's `known` is: 0 "box", 1 "table", 2 "users".
  IngestPlanTest() {
    PutObject box = Perceived("box", ObjectKind::kObject, "table");
    box.margin_m = 0.01;
    PutObject users = Perceived("users", ObjectKind::kUser, "");
    users.owner = Owner::kUser;
    Apply({{box, {}}, {Perceived("table", ObjectKind::kSupport, ""), {}}, {users, {}}});
    scene.supports.push_back(
        {.X_WO = MakeTranslation(0, 0, 1), .model = BoxModel(1), .reachable = {}});
    scene.objects.push_back({.X_WO = MakeTranslation(0, 0, 2),
                             .model = BoxModel(0.2),
                             .supported_by = 0,
                             .points_L = {}});
  }

  void Apply(const std::vector<Change>& changes) {
    match.snapshot = *collision::Apply(
        match.snapshot ? match.snapshot : std::make_shared<const collision::WorldSnapshot>(),
        changes);
    match.known.assign(match.snapshot->objects().begin(), match.snapshot->objects().end());
  }
  void Decide(std::vector<Association> associations) {
    match.associations = std::move(associations);
  }
  absl::StatusOr<IngestPlan> Plan(IngestMode mode = IngestMode::kUpdate) {
    const Detections detections(scene);
    DetectionGeometry geometry(detections);
    return PlanIngest(match, detections, mode, geometry,
                      [this](const std::string& stem) { return absl::StrCat(stem, "_", ++given); });
  }
  IngestPlan MustPlan(IngestMode mode = IngestMode::kUpdate) {
    auto plan = Plan(mode);
    EXPECT_TRUE(plan.ok()) << plan.status();
    return plan.ok() ? *std::move(plan) : IngestPlan{};
  }
  static const PutObject& PutOf(const Change& change) { return std::get<PutObject>(change.what); }

  const Association keep_table{.outcome = Outcome::kKeep, .known = 1, .support = 0};
  const Association keep_box{.outcome = Outcome::kKeep, .known = 0, .object = 0};
  SceneMatch match;
  perception::SceneInterpretation scene;
  int given = 0;
};

TEST_F(IngestPlanTest, KeepingChangesNothing) {
  Decide({keep_table, keep_box});
  const IngestPlan plan = MustPlan();
  EXPECT_THAT(plan.changes, IsEmpty());
  EXPECT_THAT(plan.names, ElementsAre("table", "box"));
  EXPECT_THAT(plan.kept, ElementsAre("table", "box"));
}

TEST_F(IngestPlanTest, WhatIsAttachedStaysAsItIsWhateverTheAssociationsSay) {
  Apply({{PutArm("arm"), {}},
         {collision::AttachObject{.name = "box", .robot = "arm", .link = "tip"}, {}}});
  for (const Outcome what : {Outcome::kMove, Outcome::kReplace, Outcome::kKeep}) {
    Decide(
        {keep_table, {.outcome = what, .known = 0, .object = 0, .X_WO = MakeTranslation(0, 0, 3)}});
    const IngestPlan plan = MustPlan();
    EXPECT_THAT(plan.changes, IsEmpty());
    EXPECT_THAT(plan.names, ElementsAre("table", "box"));
  }
  scene.objects.clear();
  for (const Outcome what : {Outcome::kRemove, Outcome::kOcclude}) {
    Decide({keep_table, {.outcome = what, .known = 0}});
    const IngestPlan plan = MustPlan();
    EXPECT_THAT(plan.changes, IsEmpty());
    EXPECT_THAT(plan.removed, IsEmpty());
  }
}

TEST_F(IngestPlanTest, ReplacingKeepsNameAndMarginAndTakesModelAndPose) {
  Decide({keep_table, {.outcome = Outcome::kReplace, .known = 0, .object = 0}});
  const IngestPlan plan = MustPlan();
  ASSERT_EQ(plan.changes.size(), 1u);
  const PutObject& put = PutOf(plan.changes[0]);
  EXPECT_EQ(put.name, "box");
  EXPECT_EQ(put.margin_m, 0.01);
  EXPECT_EQ(put.geometry->model, scene.objects[0].model);
  EXPECT_EQ(put.geometry->parts.size(), 1u);
  EXPECT_EQ(put.X_WO.translation().z(), 2);
  EXPECT_EQ(put.owner, Owner::kPerception);
  EXPECT_THAT(plan.replaced, ElementsAre("box"));
}

TEST_F(IngestPlanTest, NewThingsAreNamedAfterTheirKindAndSupporter) {
  scene.objects.push_back(
      {.kind = perception::DetectedKind::kResidual, .model = BoxModel(0.1), .points_L = {}});
  Decide({{.outcome = Outcome::kAdd, .object = 1},
          {.outcome = Outcome::kAdd, .object = 0},
          {.outcome = Outcome::kAdd, .support = 0},
          {.outcome = Outcome::kKeep, .known = 0},
          {.outcome = Outcome::kKeep, .known = 1}});
  const IngestPlan plan = MustPlan();
  EXPECT_THAT(plan.names, ElementsAre("support_1", "object_2", "residual_3"));
  ASSERT_EQ(plan.changes.size(), 3u);
  EXPECT_EQ(PutOf(plan.changes[0]).kind, ObjectKind::kSupport);
  EXPECT_EQ(PutOf(plan.changes[1]).supported_by, "support_1");
  EXPECT_EQ(PutOf(plan.changes[2]).kind, ObjectKind::kResidual);
  EXPECT_EQ(PutOf(plan.changes[2]).supported_by, "");
  EXPECT_THAT(plan.kept, IsEmpty()) << "what lies outside the view is not told";
}

TEST_F(IngestPlanTest, WhatRestsOnAnObjectNamesItEvenWhenThatIsListedLater) {
  scene.objects.push_back(scene.objects[0]);
  scene.objects[0].rests_on = 1;
  Decide({{.outcome = Outcome::kAdd, .object = 0},
          {.outcome = Outcome::kAdd, .object = 1},
          {.outcome = Outcome::kAdd, .support = 0}});
  const IngestPlan plan = MustPlan();
  ASSERT_EQ(plan.changes.size(), 3u);
  EXPECT_THAT(plan.names, ElementsAre("support_1", "object_2", "object_3"));
  EXPECT_EQ(PutOf(plan.changes[1]).supported_by, "object_3");
  EXPECT_EQ(PutOf(plan.changes[2]).supported_by, "support_1");
}

TEST_F(IngestPlanTest, SeeingAnOccludedObjectConfirmsIt) {
  PutObject box = Perceived("box", ObjectKind::kObject, "table");
  box.state = ObjectState::kOccluded;
  Apply({{box, {}}});
  Decide({keep_table, keep_box});
  const IngestPlan plan = MustPlan();
  ASSERT_EQ(plan.changes.size(), 1u);
  EXPECT_EQ(PutOf(plan.changes[0]).state, ObjectState::kConfirmed);
  EXPECT_EQ(PutOf(plan.changes[0]).geometry, match.known[0]->geometry);
}

TEST_F(IngestPlanTest, ALostSupporterIsCorrectedWhereItWasNamed) {
  Decide({{.outcome = Outcome::kRemove, .known = 1},
          {.outcome = Outcome::kAdd, .support = 0},
          keep_box});
  const IngestPlan plan = MustPlan();
  ASSERT_EQ(plan.changes.size(), 3u);
  EXPECT_EQ(PutOf(plan.changes[1]).name, "box");
  EXPECT_EQ(PutOf(plan.changes[1]).supported_by, "support_1");
  EXPECT_THAT(plan.removed, ElementsAre("table"));
}

TEST_F(IngestPlanTest, AddingDropsMovesRemovalsAndOcclusions) {
  Decide({{.outcome = Outcome::kOcclude, .known = 1},
          {.outcome = Outcome::kAdd, .support = 0},
          {.outcome = Outcome::kMove, .known = 0, .object = 0, .X_WO = MakeTranslation(5, 0, 0)}});
  const IngestPlan plan = MustPlan(IngestMode::kAdd);
  ASSERT_EQ(plan.changes.size(), 1u);
  EXPECT_EQ(PutOf(plan.changes[0]).name, "support_1");
  EXPECT_THAT(plan.names, ElementsAre("support_1", "box"));
  EXPECT_THAT(plan.moved, IsEmpty());
  EXPECT_THAT(plan.occluded, IsEmpty());

  Decide({keep_table,
          {.outcome = Outcome::kAdd, .object = 0},
          {.outcome = Outcome::kRemove, .known = 0}});
  EXPECT_THAT(MustPlan(IngestMode::kAdd).removed, IsEmpty());
  EXPECT_THAT(MustPlan(IngestMode::kUpdate).removed, ElementsAre("box"));
}

TEST_F(IngestPlanTest, AUsersObjectIsNeverChangedWhateverIsDecided) {
  for (const Outcome what : {Outcome::kMove, Outcome::kReplace, Outcome::kKeep}) {
    Decide({keep_table,
            {.outcome = what, .known = 2, .object = 0},
            {.outcome = Outcome::kKeep, .known = 0}});
    EXPECT_THAT(MustPlan().changes, IsEmpty());
  }
  for (const Outcome what : {Outcome::kRemove, Outcome::kOcclude}) {
    Decide({keep_table, keep_box, {.outcome = what, .known = 2}});
    EXPECT_THAT(MustPlan().changes, IsEmpty());
  }
}

TEST_F(IngestPlanTest, WhatAUserExplainsMakesNothing) {
  Decide({keep_table,
          {.outcome = Outcome::kExplained, .object = 0},
          {.outcome = Outcome::kKeep, .known = 0}});
  const IngestPlan plan = MustPlan();
  EXPECT_THAT(plan.changes, IsEmpty());
  EXPECT_THAT(plan.names, ElementsAre("table", ""));
}

TEST_F(IngestPlanTest, AssociationsThatDoNotFitTheSceneAreAnInternalError) {
  const std::vector<std::vector<Association>> broken = {
      {keep_table},                                                        // none for the object
      {keep_table, keep_box, {.outcome = Outcome::kAdd, .object = 0}},     // two for the object
      {keep_table, keep_box, {.outcome = Outcome::kAdd, .object = 1}},     // no such object
      {keep_table, {.outcome = Outcome::kKeep, .known = 3, .object = 0}},  // no such known object
      {keep_table,
       {.outcome = Outcome::kMove, .known = -1, .object = 0}},  // without a known object
      {keep_table, keep_box, {.outcome = Outcome::kAdd}},       // neither known nor detected
  };
  for (const auto& associations : broken) {
    Decide(associations);
    EXPECT_EQ(Plan().status().code(), absl::StatusCode::kInternal);
  }
}

TEST_F(IngestPlanTest, PreparingStopsWhenToldTo) {
  Decide({{.outcome = Outcome::kAdd, .support = 0}, {.outcome = Outcome::kAdd, .object = 0}});
  DetectionGeometry geometry{Detections(scene)};
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(geometry.PrepareFor(match, IngestMode::kUpdate, {.stop = stop.get_token()}).code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace cwm::server
