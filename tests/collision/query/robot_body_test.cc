#include "collision/query/robot_body.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "collision/engines/engine.h"
#include "collision/robot/kinematics.h"
#include "collision/robot/srdf.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/robot/panda_files.h"
#include "tests/collision/robot/three_ball_arm.h"

namespace cwm::collision {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using testing::ThreeBallArm;

class BallArm : public ::testing::Test {
 protected:
  void SetUp() override {
    model_ = ThreeBallArm();
    robot_ = PrepareRobot(model_, std::nullopt);
  }

  CollisionColumns Check(std::vector<double> rows, RobotScope scope, QueryOptions options = {}) {
    const JointRows joint_rows(*model_, model_->all, States(rows));
    return *CheckCollisions(*world_, BodyFromRobot(*robot_, scope), joint_rows, options);
  }
  JointRows::States States(std::span<const double> rows) const {
    return {.X_WB = Pose::Identity(), .base = DefaultVariables(*model_), .rows = rows};
  }

  std::shared_ptr<const RobotModel> model_;
  std::shared_ptr<const RobotGeometry> robot_;
  // A post beyond the outstretched arm, whose last ball ends at x = 1.1.
  std::shared_ptr<const WorldSnapshot> world_ = WorldOf({PutOf(
      "post", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}, MakeTranslation(0, 1, 0))});
  static constexpr double kToPost = std::numbers::pi / 2;
};

TEST_F(BallArm, MeetsTheWorldWhereItsStateBringsIt) {
  const CollisionColumns columns = Check({0, 0, kToPost, 0, 3, 0}, RobotScope::kWorld);
  EXPECT_THAT(columns.verdict, ElementsAre(Verdict::kFree, Verdict::kCollision, Verdict::kFree));
  EXPECT_THAT(columns.object, ElementsAre(-1, 0, -1));
  EXPECT_THAT(columns.body_part, ElementsAre(-1, 2, -1));  // the last ball
}

TEST_F(BallArm, MeetsItselfWhereItIsBentBack) {
  // The first and the last ball touch if 2 * 0.5 * sin(x / 2) = 0.2 for x = pi - |elbow|.
  const double touching = std::numbers::pi - 2 * std::asin(0.2);
  const std::vector<double> rows = {0, 0.999 * touching, 0, 1.001 * touching};
  const CollisionColumns columns = Check(rows, RobotScope::kBoth);
  EXPECT_THAT(columns.verdict, ElementsAre(Verdict::kFree, Verdict::kCollision));
  EXPECT_THAT(columns.object, ElementsAre(-1, kSelfObject));
  EXPECT_THAT(columns.body_part, ElementsAre(-1, 0));
  EXPECT_THAT(columns.object_part, ElementsAre(-1, 2));
}

TEST_F(BallArm, IsAskedOnlyForItsScope) {
  const std::vector<double> bent = {0, 2.9}, at_post = {kToPost, 0};
  EXPECT_EQ(Check(bent, RobotScope::kWorld).verdict[0], Verdict::kFree);
  EXPECT_EQ(Check(bent, RobotScope::kSelf).verdict[0], Verdict::kCollision);
  EXPECT_EQ(Check(at_post, RobotScope::kSelf).verdict[0], Verdict::kFree);
  EXPECT_EQ(Check(at_post, RobotScope::kBoth).verdict[0], Verdict::kCollision);
}

TEST_F(BallArm, BeyondItsLimitsHasAVerdictOfItsOwn) {
  const CollisionColumns columns = Check({3, 0, 3.001, 0, 0, -3.001}, RobotScope::kBoth);
  EXPECT_THAT(columns.verdict,
              ElementsAre(Verdict::kFree, Verdict::kOutOfLimits, Verdict::kOutOfLimits));
  EXPECT_EQ(columns.completed, 3u);
}

TEST_F(BallArm, KeepsTheMarginOfTheRequestFromTheWorldAndFromItself) {
  const std::vector<double> rows = {0.9, 0.3, 0, 2.6};
  EXPECT_THAT(Check(rows, RobotScope::kBoth).verdict, ElementsAre(Verdict::kFree, Verdict::kFree));
  const auto distances = [&](RobotScope scope, std::size_t row) {
    const JointRows joint_rows(*model_, model_->all, States(rows));
    const PairColumns columns =
        *GetDistances(*world_, BodyFromRobot(*robot_, scope), joint_rows, {});
    return columns.distance_m[columns.row_begin[row]];
  };
  const double to_post_m = distances(RobotScope::kWorld, 0);
  const double to_itself_m = distances(RobotScope::kSelf, 1);
  EXPECT_NEAR(to_itself_m, 2 * 0.5 * std::sin((std::numbers::pi - 2.6) / 2) - 0.2, 1e-12);
  for (const auto& [margin_m, row] : {std::pair(to_post_m, 0), std::pair(to_itself_m, 1)}) {
    const auto at = static_cast<std::size_t>(row);
    EXPECT_EQ(Check(rows, RobotScope::kBoth, {.margin_m = 1.001 * margin_m}).verdict[at],
              Verdict::kCollision);
    EXPECT_EQ(Check(rows, RobotScope::kBoth, {.margin_m = 0.999 * margin_m}).verdict[at],
              Verdict::kFree);
  }
}

TEST_F(BallArm, IsToItselfLikeOneMoreObject) {
  const std::vector<double> rows = {1, 2.6};
  const JointRows joint_rows(*model_, model_->all, States(rows));
  const QueryBody body = BodyFromRobot(*robot_, RobotScope::kBoth);
  const PairColumns both = *GetDistances(*world_, body, joint_rows, {.max_results = 5});
  EXPECT_THAT(both.object, ElementsAre(kSelfObject, 0));
  const PairColumns contacts = *GetContacts(*world_, body, joint_rows, {.margin_m = 10});
  EXPECT_EQ(std::ranges::count(contacts.object, kSelfObject), 1);
  EXPECT_EQ(std::ranges::count(contacts.object, 0), 3);
  // The normal points from the link that is earlier in the URDF to the later one.
  const Vector3 normal(contacts.normal[0], contacts.normal[1], contacts.normal[2]);
  const Vector3 later =
      0.5 * Vector3(std::cos(1), std::sin(1), 0) + 0.5 * Vector3(std::cos(3.6), std::sin(3.6), 0);
  EXPECT_LT((normal - later.normalized()).norm(), 1e-12);
}

TEST_F(BallArm, AGroupWithoutVariablesHasItsBaseAsTheOnlyRow) {
  const JointGroup none;
  const JointRows rows(*model_, none, {.X_WB = Pose::Identity(), .base = {kToPost, 0}});
  EXPECT_EQ(rows.size(), 1u);
  EXPECT_THAT(rows.State(0), ElementsAre(kToPost, 0));
  const QueryBody body = BodyFromRobot(*robot_, RobotScope::kBoth);
  EXPECT_THAT(CheckCollisions(*world_, body, rows, {})->verdict, ElementsAre(Verdict::kCollision));
}

// Spheres equal to the links' shapes give the same answers as these, but claim no accuracy.
TEST_F(BallArm, OfSpheresAnswersAsItsSpheresAreAndClaimsNothing) {
  SphereModel spheres;
  for (const ModelLink& link : model_->links) {
    spheres.links.emplace_back(link.collisions.size(), LinkSphere{.radius_m = 0.1});
  }
  const std::vector<double> states = {0, 0, kToPost, 0, 0, 2.9, 3.1, 0, 0.3, 2};
  const JointRows rows(*model_, model_->all, States(states));
  for (RobotScope scope : {RobotScope::kWorld, RobotScope::kSelf, RobotScope::kBoth}) {
    const QueryBody exact = BodyFromRobot(*robot_, scope);
    const QueryBody body = BodyFromSpheres(*robot_, spheres, scope);
    EXPECT_EQ(body.frame_of_part, exact.frame_of_part);
    EXPECT_EQ(body.self_pairs, exact.self_pairs);
    const auto loaded = PrepareRobot(model_, spheres);
    EXPECT_EQ(BodyFromSpheres(*loaded, *loaded->prepared_spheres_as_given, scope).geometry,
              loaded->prepared_spheres_as_given->geometry)
        << "shared, not made anew";
    const CollisionColumns checked = *CheckCollisions(*world_, body, rows, {});
    const CollisionColumns of_exact = *CheckCollisions(*world_, exact, rows, {});
    EXPECT_EQ(checked.verdict, of_exact.verdict);
    EXPECT_EQ(checked.object_part, of_exact.object_part);
    EXPECT_THAT(checked.accuracy, Each(Accuracy::kDegraded));
    const PairColumns near = *GetDistances(*world_, body, rows, {.max_results = 2});
    EXPECT_EQ(near.distance_m, GetDistances(*world_, exact, rows, {.max_results = 2})->distance_m);
    EXPECT_THAT(near.accuracy, Each(Accuracy::kDegraded));
    EXPECT_THAT(GetContacts(*world_, body, rows, {.margin_m = 1})->accuracy,
                Each(Accuracy::kDegraded));
  }
}

// A sphere beside its link is at the given position.
TEST_F(BallArm, OfSpheresHasThemWhereTheyAreGivenInTheirLinks) {
  SphereModel spheres;
  spheres.links.resize(model_->links.size());
  const auto hand = static_cast<std::size_t>(*model_->FindLink("e"));
  spheres.links[hand] = {{.center_L = {0, 0.2, 0}, .radius_m = 0.05},
                         {.center_L = {0.3, 0, 0}, .radius_m = 0.1}};
  const QueryBody body = BodyFromSpheres(*robot_, spheres, RobotScope::kBoth);
  EXPECT_TRUE(body.self_pairs.empty()) << "one link alone has any";
  const std::vector<double> outstretched = {kToPost, 0};  // the hand is in the post's ball
  const JointRows rows(*model_, model_->all, States(outstretched));
  const PairColumns near = *GetContacts(*world_, body, rows, {.margin_m = 1});
  ASSERT_EQ(near.distance_m.size(), 2u);
  EXPECT_NEAR(near.distance_m[0], 0.2 - 0.15, 1e-12);
  EXPECT_NEAR(near.distance_m[1], 0.3 - 0.2, 1e-12);
}

// The verdict without bounds or broad phase: every part against every part of the world and of the
// body.
Verdict Plainly(const WorldSnapshot& world, const QueryBody& body, const std::vector<Pose>& X_WL,
                const Engine& engine) {
  const int slot = static_cast<int>(engine.kind());
  std::vector<Pose> X_WP;
  for (std::size_t k = 0; k < body.geometry->parts.size(); ++k) {
    X_WP.push_back(X_WL[static_cast<std::size_t>(body.frame_of_part[k])] *
                   body.geometry->parts[k].X_OP);
  }
  const auto placed = [&](std::size_t k) {
    const PreparedPart& part = body.geometry->parts[k];
    return PlacedGeometry{KindOf(part.shape), *part.engines[slot], X_WP[k]};
  };
  for (const auto& [first, second] : body.self_pairs) {
    if (engine.Collides(placed(static_cast<std::size_t>(first)),
                        placed(static_cast<std::size_t>(second)))) {
      return Verdict::kCollision;
    }
  }
  for (const WorldObjectPtr& object : world.objects()) {
    for (std::size_t o = 0; o < object->parts_W.size(); ++o) {
      const PreparedPart& theirs = object->geometry->parts[o];
      const PlacedGeometry other{KindOf(theirs.shape), *theirs.engines[slot],
                                 object->parts_W[o].X_WP};
      for (std::size_t k = 0; k < X_WP.size(); ++k) {
        if (engine.Collides(placed(k), other)) return Verdict::kCollision;
      }
    }
  }
  return Verdict::kFree;
}

TEST(PandaBody, HasTheVerdictsOfAllPairsAskedPlainly) {
  const auto files = testing::ReadPandaFiles();
  if (!files) GTEST_SKIP() << "the Panda (motion_bench_maker) is not in CWM_DATA";
  const RobotDescription description = *ReadUrdf(files->urdf, files->meshes);
  const SemanticDescription semantic = *ReadSrdf(files->srdf, description);
  const auto model = *MakeRobotModel(description, &semantic);
  const QueryBody body = BodyFromRobot(*PrepareRobot(model, std::nullopt), RobotScope::kBoth);
  const JointGroup& arm = *model->FindGroup("panda_arm");
  std::mt19937 random(4);
  std::vector<Change> posts;
  for (int k = 0; k < 12; ++k) {
    Pose X_WO = RandomPose(random, 1.0);
    X_WO.translation().z() = std::abs(X_WO.translation().z());
    posts.push_back(PutOf("post" + std::to_string(k),
                          {{.X_FS = Pose::Identity(), .shape = Box{{0.1, 0.1, 0.3}}}}, X_WO));
  }
  const auto world = WorldOf(posts);
  constexpr std::size_t kStates = 400;
  std::vector<double> rows;
  for (std::size_t k = 0; k < kStates; ++k) {
    for (int variable : arm.variables) {
      const Variable& v = model->variables[static_cast<std::size_t>(variable)];
      rows.push_back(std::uniform_real_distribution<double>(v.lower, v.upper)(random));
    }
  }
  const JointRows joint_rows(*model, arm, {.base = DefaultVariables(*model), .rows = rows});
  const CollisionColumns columns = *CheckCollisions(*world, body, joint_rows, {});
  std::vector<Pose> X_WL(model->links.size());
  std::array<int, 2> of_each{};
  for (std::size_t k = 0; k < kStates; ++k) {
    joint_rows.Place(k, X_WL);
    for (EngineKind kind : {EngineKind::kExact, EngineKind::kFcl}) {
      EXPECT_EQ(columns.verdict[k], Plainly(*world, body, X_WL, GetEngine(kind))) << k;
    }
    ++of_each[columns.verdict[k] == Verdict::kCollision];
  }
  EXPECT_GT(of_each[0], 40);
  EXPECT_GT(of_each[1], 40);
}

}  // namespace
}  // namespace cwm::collision
