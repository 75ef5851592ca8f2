#include "collision/motion/check_motions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "collision/geometry/signed_distance.h"
#include "collision/robot/kinematics.h"
#include "collision/robot/srdf.h"
#include "tests/collision/motion/dense_samples.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/robot/panda_files.h"

namespace cwm::collision {
namespace {

using Edges = std::vector<std::unique_ptr<BodyMotion>>;

QueryBody BallBody() { return BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}); }

std::shared_ptr<const WorldSnapshot> BallAtOrigin() {
  return WorldOf(
      {PutOf("ball", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}, Pose::Identity())});
}

// Moves from x = -1 to 1, past the ball at the origin at a distance of `aside_m`.
MotionColumns Past(double aside_m, const QueryOptions& options = {}) {
  const QueryBody body = BallBody();
  Edges edges;
  edges.push_back(std::make_unique<RigidMotion>(body, MakeTranslation(-1, aside_m, 0),
                                                MakeTranslation(1, aside_m, 0)));
  return *CheckMotions(*BallAtOrigin(), body, edges, options);
}

TEST(CheckMotions, BracketsTheFirstContact) {
  const MotionColumns columns = Past(0.1);
  ASSERT_EQ(columns.verdict[0], MotionVerdict::kContact);
  const double truth = 0.5 * (1 - std::sqrt(0.04 - 0.01));  // where the distance is two radii
  EXPECT_LE(columns.lo[0], truth);
  EXPECT_GE(columns.hi[0], truth);
  EXPECT_LE(columns.hi[0] - columns.lo[0], kMaxBracketWidth);
  EXPECT_EQ(columns.object[0], 0);
}

// The contact with the first ball is known before the second ball is followed, and only up to it.
// The second ball is measured at other fractions; the last free one of these is behind the first
// contact.
TEST(CheckMotions, IsFreeOfAllThatItMeetsNearlyAtOnce) {
  const double first = 0.915468, second = 0.9155;
  const std::vector<Placed<>> ball = {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}};
  const auto world = WorldOf({PutOf("first", ball, MakeTranslation(first + 0.2, 0, 0)),
                              PutOf("second", ball, MakeTranslation(second + 0.2, 0, 0))});
  const QueryBody body = BallBody();
  Edges edges;
  edges.push_back(std::make_unique<RigidMotion>(body, Pose::Identity(), MakeTranslation(1, 0, 0)));
  const MotionColumns columns = *CheckMotions(*world, body, edges, {});
  ASSERT_EQ(columns.verdict[0], MotionVerdict::kContact);
  EXPECT_LE(columns.lo[0], first);
  EXPECT_GE(columns.hi[0], first);
  EXPECT_LE(columns.hi[0] - columns.lo[0], kMaxBracketWidth);
}

// A box that slides over a ball and turns comes nearer by eight millimetres over the edge. If a
// halving point is just before the contact, the gap there is smaller than what can be proven.
TEST(CheckMotions, BracketsAContactThatAHalfFallsJustBefore) {
  constexpr double kHalf = 12022.0 / 16384;
  const Box box{.size_m = {0.1, 0.08, 0.2}};
  const QueryBody body = BodyFromShapes({{.shape = box}});
  Pose from = MakeTranslation(0.3247, -0.4657, 0.0443),
       to = MakeTranslation(0.3344, -0.4419, 0.0422);
  from.linear() = Quaternion(0.1442, 0.9813, -0.1243, 0.0270).normalized().toRotationMatrix();
  to.linear() = Quaternion(0.1750, 0.9753, -0.1309, 0.0317).normalized().toRotationMatrix();
  const Vector3 p_WBall(0.3834, -0.4344, 0.1947);
  for (double gap_m = 1e-9; gap_m < 5e-8; gap_m += 1e-9) {
    Edges edges;
    edges.push_back(std::make_unique<RigidMotion>(body, from, to));
    std::array<Pose, 1> at_half;
    edges.front()->Place(kHalf, at_half);
    const double radius_m = SignedDistance_m(box, at_half[0].inverse() * p_WBall) - gap_m;
    const auto world = WorldOf({PutOf("ball", {{.shape = Sphere{radius_m}}},
                                      MakeTranslation(p_WBall.x(), p_WBall.y(), p_WBall.z()))});
    const MotionColumns columns = *CheckMotions(*world, body, edges, {});
    ASSERT_EQ(columns.verdict[0], MotionVerdict::kContact) << gap_m;
    EXPECT_LT(columns.lo[0], kHalf + kMaxBracketWidth) << gap_m;
    EXPECT_GT(columns.hi[0], kHalf) << gap_m;
    EXPECT_LE(columns.hi[0] - columns.lo[0], kMaxBracketWidth) << gap_m;
  }
}

TEST(CheckMotions, ProvesAMissOfAMillimetre) {
  const MotionColumns columns = Past(0.201);
  ASSERT_EQ(columns.verdict[0], MotionVerdict::kFree);
  EXPECT_GT(columns.clearance_m[0], 0.0002);
  EXPECT_LE(columns.clearance_m[0], 0.001 + 1e-12);
}

TEST(CheckMotions, TellsNoClearanceThatItDidNotLookFor) {
  const MotionColumns columns = Past(3);
  ASSERT_EQ(columns.verdict[0], MotionVerdict::kFree);
  EXPECT_GT(columns.clearance_m[0], 0.01);
  EXPECT_LT(columns.clearance_m[0], 0.1);
}

// Moves onto a floor: a half-space that does not turn travels as far as its frame.
TEST(CheckMotions, AHalfSpaceSlides) {
  const auto world = WorldOf(
      {PutOf("floor", {{.X_FS = Pose::Identity(), .shape = HalfSpace{}}}, Pose::Identity())});
  const QueryBody body = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = HalfSpace{}}});
  const auto facing = [](double z_m) { return MakePose({0, 0, z_m}, Quaternion(0, 1, 0, 0)); };
  Edges edges;
  edges.push_back(std::make_unique<RigidMotion>(body, facing(1), facing(-0.5)));
  edges.push_back(std::make_unique<RigidMotion>(body, facing(1), facing(0.01)));
  edges.push_back(std::make_unique<RigidMotion>(body, Pose::Identity(), facing(1)));
  const MotionColumns columns = *CheckMotions(*world, body, edges, {});
  EXPECT_THAT(columns.verdict, ::testing::ElementsAre(MotionVerdict::kContact, MotionVerdict::kFree,
                                                      MotionVerdict::kContact));
  EXPECT_LE(columns.lo[0], 2.0 / 3);
  EXPECT_GE(columns.hi[0], 2.0 / 3);
  EXPECT_EQ(columns.hi[2], 0);  // coincident planes from the beginning
}

TEST(CheckMotions, GrazesWhereItAllButTouches) {
  EXPECT_EQ(Past(0.2 + 1e-7).verdict[0], MotionVerdict::kGrazing);
  EXPECT_EQ(Past(0.2 - 1e-5).verdict[0], MotionVerdict::kContact);
  EXPECT_EQ(Past(0.2 + 1e-5).verdict[0], MotionVerdict::kFree);
}

TEST(CheckMotions, KeepsTheMargin) {
  EXPECT_EQ(Past(0.25, {.margin_m = 0.0501}).verdict[0], MotionVerdict::kContact);
  EXPECT_EQ(Past(0.25, {.margin_m = 0.0499}).verdict[0], MotionVerdict::kFree);
}

// For a ball and a disc a thousand times larger the search leaves some micrometres open, within
// which no motion is free.
TEST(CheckMotions, IsNoSurerThanTheDistanceIs) {
  const QueryBody body = BodyFromShapes({{.shape = Capsule{0.05, 0.004}}});
  Pose X_WDisc = MakeTranslation(712 * 0.8, 712 * 0.2, 712);
  X_WDisc.rotate(Eigen::AngleAxisd(-0.1, Vector3::UnitX()));
  X_WDisc.rotate(Eigen::AngleAxisd(0.4, Vector3::UnitY()));
  const auto world = WorldOf({PutOf("disc", {{.shape = Cylinder{800, 0.002}}}, X_WDisc)});
  const std::vector<Pose> here = {Pose::Identity()};
  const PairColumns gap = *GetDistances(*world, body, here, {});
  const double distance_m = gap.distance_m[0], bound_m = gap.bound_m[0];
  ASSERT_GT(bound_m, kGrazingTolerance_m);
  const Vector3 nhat(gap.normal[0], gap.normal[1], gap.normal[2]);
  Pose away = here[0];
  away.translation() -= 0.001 * nhat;
  for (const Pose& to : {here[0], away}) {
    const auto result = [&](double margin_m) {
      Edges edges;
      edges.push_back(std::make_unique<RigidMotion>(body, here[0], to));
      return *CheckMotions(*world, body, edges, {.margin_m = margin_m});
    };
    const double open_m = distance_m - 0.5 * bound_m;
    EXPECT_EQ(CheckCollisions(*world, body, here, {.margin_m = open_m})->verdict[0],
              Verdict::kUndecided);
    EXPECT_EQ(result(open_m).verdict[0], MotionVerdict::kUndecided);
    EXPECT_EQ(result(open_m).accuracy[0], Accuracy::kBounded);
    EXPECT_EQ(result(distance_m + 2 * bound_m).verdict[0], MotionVerdict::kContact);
    const MotionColumns free = result(distance_m - 2 * bound_m);
    EXPECT_EQ(free.verdict[0], MotionVerdict::kFree);
    EXPECT_LE(free.clearance_m[0], (1 + 1e-6) * bound_m);
  }
}

// A ball whose surface has a standard deviation of 5 mm.
Change FittedBall(const std::string& name, double x_m) {
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back({.X_OS = Pose::Identity(),
                           .shape = Sphere{0.1},
                           .fit = FitQuality{.rms_m = 1, .parameter_sigma = {0, 0, 0.003, 0.002}}});
  PutObject put;
  put.name = name;
  put.X_WO = MakeTranslation(x_m, 0, 0);
  put.geometry = Prepare(std::move(model));
  return {.what = std::move(put), .expected_object_revision = {}};
}

// Moves past the object at the origin, at a distance of `aside_m` from its centre.
MotionVerdict PastWithSigmas(const WorldSnapshot& world, const QueryBody& body, double aside_m,
                             double sigmas) {
  Edges edges;
  edges.push_back(std::make_unique<RigidMotion>(body, MakeTranslation(-1, aside_m, 0),
                                                MakeTranslation(1, aside_m, 0)));
  return CheckMotions(world, body, edges, {.margin_sigma = sigmas})->verdict[0];
}

TEST(CheckMotions, DeviationsOfAFitAreMarginsToo) {
  const auto world = WorldOf({FittedBall("ball", 0)});
  const QueryBody body = BallBody();
  EXPECT_EQ(PastWithSigmas(*world, body, 0.21, 0), MotionVerdict::kFree);
  EXPECT_EQ(PastWithSigmas(*world, body, 0.21, 1.99), MotionVerdict::kFree);
  EXPECT_EQ(PastWithSigmas(*world, body, 0.21, 2.01), MotionVerdict::kContact);
  // The standard deviations are added to the margin of a rule.
  const std::vector<Change> rule = {
      {.what = SetPairMargin{{{"*"}, {"ball"}}, 0.005}, .expected_object_revision = {}}};
  const auto ruled = *Apply(world, rule);
  EXPECT_EQ(PastWithSigmas(*ruled, body, 0.21, 0.99), MotionVerdict::kFree);
  EXPECT_EQ(PastWithSigmas(*ruled, body, 0.21, 1.01), MotionVerdict::kContact);
}

TEST(CheckMotions, DeviationsOfWhatMovesAreMarginsToo) {
  const auto world = WorldOf({FittedBall("ball", 0), FittedBall("moves", 1)});
  const QueryBody body = BodyFromObject(*world->Find("moves"));
  EXPECT_EQ(PastWithSigmas(*world, body, 0.22, 1.99), MotionVerdict::kFree);
  EXPECT_EQ(PastWithSigmas(*world, body, 0.22, 2.01), MotionVerdict::kContact);
}

TEST(CheckMotions, KeepsTheRulesOfPairs) {
  const auto past = [](const AllowCollision* allow, std::optional<double> margin_m,
                       const QueryOptions& options) {
    std::vector<Change> changes;
    const NamedPair pair = {{"ball"}, {"*"}};
    if (allow != nullptr) changes.push_back({.what = *allow, .expected_object_revision = {}});
    changes.push_back({.what = SetPairMargin{pair, margin_m}, .expected_object_revision = {}});
    const QueryBody body = BallBody();
    Edges edges;
    edges.push_back(std::make_unique<RigidMotion>(body, MakeTranslation(-1, 0.25, 0),
                                                  MakeTranslation(1, 0.25, 0)));
    return CheckMotions(**Apply(BallAtOrigin(), changes), body, edges, options)->verdict[0];
  };
  EXPECT_EQ(past(nullptr, 0.0501, {}), MotionVerdict::kContact);
  EXPECT_EQ(past(nullptr, 0.0499, {.margin_m = 0.1}), MotionVerdict::kFree);
  EXPECT_EQ(past(nullptr, std::nullopt, {.margin_m = 0.1}), MotionVerdict::kContact);
  const AllowCollision allow{.pair = {{"ball"}, {"*"}}};
  EXPECT_EQ(past(&allow, 0.0501, {}), MotionVerdict::kFree);
  EXPECT_EQ(past(nullptr, 0.0501, {.ignore_pairs = {{{"*"}, {"ball"}}}}), MotionVerdict::kFree);
}

TEST(CheckMotions, IsUndecidedWhereItPassesThroughUnseenSpace) {
  Change shadow = PutOf("shadow", {{.shape = Box{{0.2, 2, 2}}}}, MakeTranslation(-0.5, 0, 0));
  std::get<PutObject>(shadow.what).kind = ObjectKind::kUnseen;
  const auto world = WorldOf({shadow, PutOf("ball", {{.shape = Sphere{0.1}}}, Pose::Identity())});
  const QueryBody body = BallBody();
  const auto verdict = [&](double from_m, double to_m, UnseenSpace unseen) {
    Edges edges;
    edges.push_back(std::make_unique<RigidMotion>(body, MakeTranslation(from_m, 0, 0),
                                                  MakeTranslation(to_m, 0, 0)));
    return CheckMotions(*world, body, edges, {.unseen = unseen})->verdict[0];
  };
  EXPECT_EQ(verdict(-1, -0.25, UnseenSpace::kBlock), MotionVerdict::kContact);
  EXPECT_EQ(verdict(-1, -0.25, UnseenSpace::kReport), MotionVerdict::kUndecided);
  EXPECT_EQ(verdict(-1, -0.25, UnseenSpace::kIgnore), MotionVerdict::kFree);
  EXPECT_EQ(verdict(-1, 1, UnseenSpace::kReport), MotionVerdict::kContact);
  EXPECT_EQ(verdict(0.5, 1, UnseenSpace::kReport), MotionVerdict::kFree);
}

TEST(CheckMotions, BeginsInContact) {
  const QueryBody body = BallBody();
  Edges edges;
  edges.push_back(
      std::make_unique<RigidMotion>(body, MakeTranslation(0.1, 0, 0), MakeTranslation(1, 0, 0)));
  const MotionColumns columns = *CheckMotions(*BallAtOrigin(), body, edges, {});
  EXPECT_EQ(columns.verdict[0], MotionVerdict::kContact);
  EXPECT_EQ(columns.lo[0], 0);
  EXPECT_EQ(columns.hi[0], 0);
}

// A rod that turns by a quarter sweeps over a thin post, which it touches at neither end.
TEST(CheckMotions, ARodThatTurnsMeetsThePostOnItsWay) {
  const QueryBody rod = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Box{{2, 0.01, 0.01}}}});
  const double at_rad = 0.3, radius_m = 0.01;
  const auto world =
      WorldOf({PutOf("post", {{.X_FS = Pose::Identity(), .shape = Cylinder{radius_m, 1}}},
                     MakeTranslation(0.8 * std::cos(at_rad), 0.8 * std::sin(at_rad), 0))});
  const auto turned = [](double angle_rad) {
    return Pose(Eigen::AngleAxisd(angle_rad, Vector3::UnitZ()));
  };
  Edges edges;
  edges.push_back(std::make_unique<RigidMotion>(rod, turned(0), turned(1.5)));
  edges.push_back(std::make_unique<RigidMotion>(rod, turned(0), turned(-1.5)));
  const MotionColumns columns = *CheckMotions(*world, rod, edges, {});
  ASSERT_EQ(columns.verdict[0], MotionVerdict::kContact);
  // The rod's side reaches the post at the angle asin of the sum of both half widths over the
  // distance.
  const double truth = (at_rad - std::asin((radius_m + 0.005) / 0.8)) / 1.5;
  EXPECT_LE(columns.lo[0], truth);
  EXPECT_GE(columns.hi[0], truth);
  EXPECT_EQ(columns.verdict[1], MotionVerdict::kFree);
}

TEST(CheckMotions, IsNeverWrongAboutBodies) {
  std::mt19937 random(5);
  const auto world = RandomWorld(24, random, true);
  const QueryBody body = Gripper();
  Edges edges;
  for (int k = 0; k < 150; ++k) {
    Pose from = RandomPose(random, 0.9), to = RandomPose(random, 0.9);
    edges.push_back(std::make_unique<RigidMotion>(body, from, to));
  }
  const MotionColumns columns = *CheckMotions(*world, body, edges, {});
  Tally result;
  for (std::size_t k = 0; k < edges.size(); ++k) {
    ExpectTrue(*world, body, *edges[k], columns, k, 400, result);
  }
  EXPECT_GT(result.free, 10);
  EXPECT_GT(result.contact, 10);
  EXPECT_EQ(result.other, 0);
}

TEST(CheckMotions, IsNeverWrongAboutThePanda) {
  const auto files = testing::ReadPandaFiles();
  if (!files) GTEST_SKIP() << "the Panda (motion_bench_maker) is not in CWM_DATA";
  const RobotDescription description = *ReadUrdf(files->urdf, files->meshes);
  const SemanticDescription semantic = *ReadSrdf(files->srdf, description);
  const auto robot = PrepareRobot(*MakeRobotModel(description, &semantic), std::nullopt);
  const RobotModel& model = *robot->model;
  const QueryBody body = BodyFromRobot(*robot, RobotScope::kBoth);
  std::mt19937 random(6);
  std::vector<Change> posts;
  for (int k = 0; k < 8; ++k) {
    posts.push_back(PutOf("post" + std::to_string(k),
                          {{.X_FS = Pose::Identity(), .shape = Box{{0.05, 0.05, 0.3}}}},
                          MakeTranslation(0, 0, 0.5) * RandomPose(random, 0.8)));
  }
  const auto world = WorldOf(posts);
  const auto state = [&] {
    std::vector<double> values;
    for (const Variable& v : model.variables) {
      values.push_back(std::uniform_real_distribution<double>(v.lower, v.upper)(random));
    }
    return values;
  };
  Edges edges;
  for (int k = 0; k < 20; ++k) {
    const std::vector<double> from = state();
    std::vector<double> to = state();
    for (std::size_t v = 0; v < to.size(); ++v) to[v] = from[v] + 0.2 * (to[v] - from[v]);
    edges.push_back(std::make_unique<JointMotion>(model, body, Pose::Identity(), from, to));
  }
  const MotionColumns columns = *CheckMotions(*world, body, edges, {});
  Tally result;
  for (std::size_t k = 0; k < edges.size(); ++k) {
    ExpectTrue(*world, body, *edges[k], columns, k, 100, result);
  }
  EXPECT_GT(result.free, 2);
  EXPECT_GT(result.contact, 2);
  EXPECT_EQ(result.other, 0);
}

TEST(CheckMotions, EndsWhenItIsTold) {
  std::stop_source stop;
  stop.request_stop();
  const QueryBody body = BallBody();
  Edges edges;
  edges.push_back(
      std::make_unique<RigidMotion>(body, MakeTranslation(-1, 0, 0), MakeTranslation(1, 0, 0)));
  EXPECT_TRUE(
      absl::IsCancelled(CheckMotions(*BallAtOrigin(), body, edges, {}, stop.get_token()).status()));
  QueryOptions late;
  late.deadline = std::chrono::steady_clock::now();
  const MotionColumns columns = *CheckMotions(*BallAtOrigin(), body, edges, late);
  EXPECT_EQ(columns.completed, 0u);
  EXPECT_EQ(columns.verdict[0], MotionVerdict::kNotComputed);
}

TEST(CheckMotions, RefusesEnginesThatCannotCertify) {
  for (EngineChoice engine : {EngineChoice::kFcl, EngineChoice::kBullet}) {
    QueryOptions options;
    options.engine = engine;
    EXPECT_TRUE(
        absl::IsUnimplemented(CheckMotions(*BallAtOrigin(), BallBody(), {}, options).status()));
  }
}

}  // namespace
}  // namespace cwm::collision
