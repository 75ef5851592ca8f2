// Queries of the C++ client to a real server. The answers are worked out by hand: a ball of 0.1 m
// and a box whose face is 0.9 m away.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <thread>
#include <vector>

#include "tests/clients/cpp/running_server.h"

namespace cwm::testing {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// derived: exact kernels answer such pairs to rounding errors of a few metres.
constexpr double kTolerance_m = 1e-9;

// A world with the box "post", whose faces are at x = 0.9 and 1.1.
class Queries : public ClientTest {
 protected:
  void SetUp() override { world_.Put("post", Box{0.2, 0.2, 0.2}, At(1, 0, 0)); }

  World world_ = Connect();
  const Sphere ball_{0.1};
};

TEST_F(Queries, MeasureDistancesOfManyPoses) {
  const std::vector<Eigen::Isometry3d> poses = {At(0, 0, 0), At(0.85, 0, 0), At(1, 0, 2)};
  const PairResult answer = world_.Distance(ball_, poses);
  ASSERT_TRUE(answer.complete());
  EXPECT_THAT(answer.row_begin, ElementsAre(0, 1, 2, 3));
  EXPECT_TRUE(answer.distance_m.isApprox(Eigen::Vector3d(0.8, -0.05, 1.8), kTolerance_m))
      << answer.distance_m;
  EXPECT_TRUE(answer.point_body.col(0).isApprox(Eigen::Vector3d(0.1, 0, 0), kTolerance_m));
  EXPECT_TRUE(answer.point_object.col(0).isApprox(Eigen::Vector3d(0.9, 0, 0), kTolerance_m));
  EXPECT_TRUE(answer.normal.col(0).isApprox(Eigen::Vector3d::UnitX(), kTolerance_m));
  EXPECT_TRUE(answer.normal.col(2).isApprox(-Eigen::Vector3d::UnitZ(), kTolerance_m));
  EXPECT_THAT(answer.trust, Each(Trust::kExact));
  EXPECT_EQ(answer.pair(1).object, "post");
  EXPECT_EQ(answer.nearest_m(), answer.distance_m);
  EXPECT_EQ(answer.revision, 1);
  EXPECT_EQ(answer.world_uid, world_.uid());
}

TEST_F(Queries, FindSeveralObjectsOrNone) {
  world_.Put("wall", Box{0.2, 4, 4}, At(-2, 0, 0));
  const PairResult both = world_.Distance(ball_, At(0, 0, 0), {.max_results = 8});
  ASSERT_EQ(both.size(), 2);
  EXPECT_EQ(both.pair(0).object, "post");
  EXPECT_EQ(both.pair(1).object, "wall");
  EXPECT_NEAR(both.distance_m[1], 1.8, kTolerance_m);
  const PairResult none = world_.Distance(ball_, At(0, 0, 0), {.max_distance_m = 0.5});
  EXPECT_EQ(none.size(), 0);
  EXPECT_TRUE(std::isnan(none.nearest_m()[0]));
}

TEST_F(Queries, CheckBodiesObjectsAndPoints) {
  const std::vector<Eigen::Isometry3d> poses = {At(0, 0, 0), At(0.85, 0, 0)};
  const CheckResult ball = world_.Check(ball_, poses);
  EXPECT_THAT(ball.verdict, ElementsAre(Verdict::kFree, Verdict::kCollision));
  EXPECT_FALSE(ball.all_free());
  EXPECT_EQ(ball.pair(1).object, "post");
  EXPECT_EQ(ball.pair(1).body_link, "");
  EXPECT_TRUE(world_.Check(ball_, poses, {.ignore = {"post"}}).all_free());
  EXPECT_FALSE(world_.Check(ball_, At(0, 0, 0), {.margin_m = 0.81}).all_free());

  const Body dumbbell = {{ball_, At(-0.4, 0, 0)}, {ball_, At(0.4, 0, 0)}};
  const CheckResult two = world_.Check(dumbbell, std::vector{At(0, 0, 0), At(0.45, 0, 0)});
  EXPECT_THAT(two.verdict, ElementsAre(Verdict::kFree, Verdict::kCollision));
  EXPECT_EQ(two.body_part[1], 1);

  world_.Put("ball", ball_, At(0.5, 0, 0));
  EXPECT_TRUE(world_.Check("ball").all_free());
  EXPECT_FALSE(world_.Check("ball", At(0.85, 0, 0)).all_free());

  Eigen::Matrix3Xd points(3, 2);
  points << 0.95, 0, 0, 0, 0, 0;
  EXPECT_THAT(world_.Check(Points{points}).verdict,
              ElementsAre(Verdict::kCollision, Verdict::kFree));
}

TEST_F(Queries, ListContactsDeepestFirst) {
  const PairResult contacts =
      world_.Contacts(Box{0.2, 0.1, 0.1}, std::vector{At(0, 0, 0), At(0.81, 0, 0)});
  ASSERT_EQ(contacts.row_begin.size(), 3U);
  EXPECT_EQ(contacts.row_begin[1], 0);
  ASSERT_GT(contacts.size(), 1) << "two faces meet in a patch";
  EXPECT_NEAR(contacts.distance_m[0], -0.01, kTolerance_m);
  EXPECT_TRUE(contacts.normal.col(0).isApprox(Eigen::Vector3d::UnitX(), kTolerance_m));
  EXPECT_EQ(world_.Contacts(Box{0.2, 0.1, 0.1}, At(0.81, 0, 0), {.max_contacts = 1}).size(), 1);
}

TEST_F(Queries, CertifyMotionsAndPaths) {
  const MotionResult motions = world_.Motions(ball_, std::vector{At(0, 0, 0), At(0, 0, 0)},
                                              std::vector{At(1, 0, 0), At(0, 0, 1)});
  EXPECT_THAT(motions.verdict, ElementsAre(MotionVerdict::kContact, MotionVerdict::kFree));
  EXPECT_LE(motions.lo[0], 0.8) << "the ball meets the face 0.8 m ahead";
  EXPECT_GE(motions.hi[0], 0.8);
  EXPECT_LT(motions.hi[0] - motions.lo[0], 1e-3);
  EXPECT_EQ(motions.pair(0).object, "post");
  EXPECT_NEAR(motions.clearance_m[1], 0.02, 1e-6) << "measured up to 0.02";

  const std::vector<Eigen::Isometry3d> around = {At(0, 0, 0), At(0, 0, 1), At(2, 0, 1)};
  const std::vector<Eigen::Isometry3d> down = {At(0, 0, 0), At(1, 0, 1), At(1, 0, 0)};
  const MotionResult paths = world_.Paths(ball_, std::vector<Rows>{around, down});
  EXPECT_THAT(paths.verdict, ElementsAre(MotionVerdict::kFree, MotionVerdict::kContact));
  EXPECT_EQ(paths.segment[1], 1);
  EXPECT_TRUE(world_.Path(ball_, around).all_free());
}

TEST_F(Queries, CastRaysAndSamplePoints) {
  Eigen::Matrix3Xd directions(3, 2);
  directions << 2, 0, 0, 1, 0, 0;
  const RayResult rays = world_.Rays(Eigen::Vector3d(0, 0, 0), directions);
  EXPECT_THAT(rays.hit, ElementsAre(true, false));
  EXPECT_NEAR(rays.distance_m[0], 0.9, kTolerance_m);
  EXPECT_TRUE(rays.normal.col(0).isApprox(-Eigen::Vector3d::UnitX(), kTolerance_m));
  EXPECT_EQ(rays.object(0), "post");
  EXPECT_EQ(rays.object(1), "");

  Eigen::Matrix3Xd points(3, 2);
  points << 0, 1, 0, 0, 0, 0.09;
  const SampleResult samples = world_.Sample(points);
  EXPECT_THAT(samples.state, ElementsAre(SampleState::kSmooth, SampleState::kSmooth));
  EXPECT_NEAR(samples.distance_m[0], 0.9, kTolerance_m);
  EXPECT_NEAR(samples.distance_m[1], -0.01, kTolerance_m) << "below the upper face";
  EXPECT_TRUE(samples.gradient.col(0).isApprox(-Eigen::Vector3d::UnitX(), 1e-6));
  EXPECT_TRUE(samples.gradient.col(1).isApprox(Eigen::Vector3d::UnitZ(), 1e-6));
  EXPECT_EQ(samples.object(0), "post");
}

TEST_F(Queries, AskWithMeshesThatTheServerGetsOnTheWay) {
  Mesh tetrahedron{.vertices = Eigen::Matrix3Xd(3, 4), .triangles = Triangles(3, 4)};
  tetrahedron.vertices << 0, 1, 0, 0,  //
      0, 0, 1, 0,                      //
      0, 0, 0, 1;
  tetrahedron.triangles << 0, 0, 0, 1,  //
      2, 1, 3, 2,                       //
      1, 3, 2, 3;
  // Its corner (1, 0, 0) is 0.4 m ahead of the face once it is shifted by -0.5.
  const PairResult inside = world_.Distance(tetrahedron, At(-0.5, 0, 0));
  EXPECT_NEAR(inside.distance_m[0], 0.4, kTolerance_m);
  Convex hull;
  hull.vertices = tetrahedron.vertices;
  hull.triangles = tetrahedron.triangles;
  EXPECT_NEAR(world_.Distance(hull, At(-0.5, 0, 0)).distance_m[0], 0.4, kTolerance_m);

  const Mesh stored = world_.WriteMesh(tetrahedron);
  EXPECT_EQ(stored.vertices.cols(), 0);
  EXPECT_NEAR(world_.Distance(stored, At(-0.5, 0, 0)).distance_m[0], 0.4, kTolerance_m);
  EXPECT_EQ(world_.ReadMesh(stored.hash).vertices, tetrahedron.vertices);
}

TEST_F(Queries, CutBatchesAboveTheLimitsAtOneRevision) {
  // Twice the server's limit of rows, and some more.
  const auto count = static_cast<std::size_t>(2 * world_.server().Info().max_batch_rows + 17);
  std::vector<Eigen::Isometry3d> poses(count, At(0, 0, 0));
  for (std::size_t i = 0; i < count; ++i) {
    poses[i].translation().x() = -static_cast<double>(i) / static_cast<double>(count);
  }
  const PairResult answer = world_.Distance(ball_, poses);
  ASSERT_TRUE(answer.complete());
  ASSERT_EQ(answer.size(), static_cast<Eigen::Index>(count));
  EXPECT_EQ(answer.row_begin.back(), answer.size());
  for (const std::size_t i : {std::size_t{0}, count / 2, count - 1}) {
    EXPECT_NEAR(answer.distance_m[static_cast<Eigen::Index>(i)], 0.8 - poses[i].translation().x(),
                kTolerance_m);
  }
  // Each batch names its objects by numbers of its own.
  world_.Put("aaa", Box{0.2, 0.2, 0.2}, At(-5, 0, 0));
  poses.back() = At(-4, 0, 0);
  const PairResult named = world_.Distance(ball_, poses);
  EXPECT_EQ(named.pair(0).object, "post");
  EXPECT_EQ(named.pair(named.size() - 1).object, "aaa");
}

TEST_F(Queries, AnswerNoRowsWithNothing) {
  const PairResult answer = world_.Distance(ball_, std::vector<Eigen::Isometry3d>{});
  EXPECT_TRUE(answer.complete());
  EXPECT_EQ(answer.size(), 0);
  EXPECT_EQ(world_.Rays(Eigen::Vector3d::Zero(), Eigen::Matrix3Xd(3, 0)).hit.size(), 0U);
}

TEST_F(Queries, PinARevisionAndSupposeChanges) {
  const WorldView before = world_.At();
  world_.Remove("post");
  EXPECT_EQ(world_.Distance(ball_).size(), 0);
  EXPECT_NEAR(before.Distance(ball_).distance_m[0], 0.8, kTolerance_m);

  const WorldView supposed =
      before.WhatIf({Move{.name = "post", .X_WO = At(3, 0, 0)},
                     Put{.name = "ghost", .body = ball_, .X_WO = At(0, 1, 0)}});
  const PairResult answer = supposed.Distance(ball_, At(0, 0, 0), {.max_results = 2});
  EXPECT_EQ(answer.pair(0).object, "ghost");
  EXPECT_NEAR(answer.distance_m[0], 0.8, kTolerance_m);
  EXPECT_NEAR(answer.distance_m[1], 2.8, kTolerance_m) << "the post's face is at 2.9";
  EXPECT_EQ(answer.objects[0].uid, "") << "objects of an overlay have none";
  const PairResult alone = supposed.Distance(ball_, At(0, 0, 0), {.overlay = {Remove{"ghost"}}});
  EXPECT_EQ(alone.pair(0).object, "post");
}

TEST_F(Queries, AskOverAStreamFromSeveralThreads) {
  const WorldView stream = world_.At().WhatIf({Move{.name = "post", .X_WO = At(2, 0, 0)}}).Stream();
  world_.Remove("post");
  std::vector<std::thread> threads;
  std::vector<double> farthest_m(4, 0);
  for (std::size_t t = 0; t < farthest_m.size(); ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 50; ++i) {
        // The face is at 1.9; each thread asks from a place of its own.
        const double x = -static_cast<double>(t);
        const PairResult answer = stream.Distance(ball_, At(x, 0, 0));
        farthest_m[t] = std::max(farthest_m[t], std::abs(answer.distance_m[0] - (1.8 - x)));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(farthest_m, Each(::testing::Lt(kTolerance_m)));
  // A query that fails leaves the stream as it is, with the error of a call.
  const Error unknown = ErrorOf([&] { stream.Check("nobody"); });
  EXPECT_EQ(unknown.code(), ErrorCode::kNotFound);
  EXPECT_EQ(unknown.reason(), "OBJECT_UNKNOWN");
  EXPECT_EQ(unknown.metadata().at("object"), "nobody");
  EXPECT_EQ(stream.Rays(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()).object(0), "post");
}

TEST_F(Queries, SayWhatIsWrongWithAnArgument) {
  Eigen::Isometry3d stretched = At(0, 0, 0);
  stretched.linear() *= 1.01;
  const Error pose = ErrorOf([&] {
    world_.Distance(ball_, std::vector<Eigen::Isometry3d>{At(0, 0, 0), stretched});
  });
  EXPECT_EQ(pose.code(), ErrorCode::kInvalidArgument);
  ASSERT_EQ(pose.fields().size(), 1U);
  EXPECT_EQ(pose.fields()[0].field, "rows[1]");
  EXPECT_THAT(pose.what(), HasSubstr("rows[1]: is no rigid transform"));

  const Error radius = ErrorOf([&] { world_.Distance(Sphere{-1}, At(0, 0, 0)); });
  EXPECT_EQ(radius.code(), ErrorCode::kInvalidArgument);
  ASSERT_EQ(radius.fields().size(), 1U);
  EXPECT_THAT(radius.fields()[0].field, HasSubstr("sphere.radius_m"));
  EXPECT_THAT(radius.what(), HasSubstr("-1")) << "the value and the rule";

  const Error numbers = ErrorOf([&] { world_.Check(ball_, Eigen::VectorXd::Zero(7)); });
  EXPECT_THAT(numbers.what(), HasSubstr("must be poses"));
  const Error poses = ErrorOf([&] { world_.Check(RobotSubject{"arm"}, At(0, 0, 0)); });
  EXPECT_THAT(poses.what(), HasSubstr("must be joint values"));
  const Error ends = ErrorOf([&] {
    world_.Motions(ball_, At(0, 0, 0), std::vector{At(0, 0, 0), At(1, 0, 0)});
  });
  EXPECT_THAT(ends.what(), HasSubstr("ends: are 2"));
  EXPECT_EQ(ErrorOf([&] { world_.Path(ball_, At(0, 0, 0)); }).fields()[0].field, "paths[0]");
}

TEST_F(Queries, StopAtATimeBudget) {
  const std::vector<Eigen::Isometry3d> poses(20'000, At(0, 0, 0));
  const CheckResult answer = world_.Check(ball_, poses, {.time_budget_s = 1e-9});
  EXPECT_FALSE(answer.complete());
  EXPECT_FALSE(answer.all_free()) << "rows without an answer are not free";
  EXPECT_EQ(answer.row_count, 20'000);
  EXPECT_EQ(static_cast<Eigen::Index>(answer.verdict.size()), answer.completed_count);
}

}  // namespace
}  // namespace cwm::testing
