// The accuracy of answers about motions, compared with that of the states along them.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "collision/motion/check_paths.h"
#include "collision/robot/kinematics.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/robot/three_ball_arm.h"

namespace cwm::collision {
namespace {

using testing::ThreeBallArm;
using SnapshotPtr = std::shared_ptr<const WorldSnapshot>;

QueryBody BallBody() { return BodyFromShapes({{.shape = Sphere{0.1}}}); }

Change Ball(const std::string& name, double x_m) {
  return PutOf(name, {{.shape = Sphere{0.1}}}, MakeTranslation(x_m, 0, 0));
}

// A box of 2 m without its lid: an open mesh.
Change Bin(double x_m) {
  TriangleMesh mesh = BoxMesh({2, 2, 2});
  std::erase_if(mesh.triangles, [&](const TriangleMesh::Triangle& triangle) {
    return std::ranges::all_of(triangle, [&](auto v) { return mesh.vertices[v].z() > 0; });
  });
  return PutOf("bin", {{.shape = MakeMesh(std::move(mesh))}}, MakeTranslation(x_m, 0, 0));
}

// Moves the ball along x.
MotionResult Along(const SnapshotPtr& world, double from_m, double to_m,
                   const QueryOptions& options = {}) {
  const QueryBody body = BallBody();
  EdgeChecker checker(*world, body, options, {});
  return checker.Check(
      RigidMotion(body, MakeTranslation(from_m, 0, 0), MakeTranslation(to_m, 0, 0)));
}

TEST(MotionAccuracy, OfAnOpenMeshIsItsSurfaceAlone) {
  const SnapshotPtr world = WorldOf({Bin(0)});
  const MotionResult inside = Along(world, -0.1, 0.1);  // nowhere near the surface
  EXPECT_EQ(inside.verdict, MotionVerdict::kFree);
  EXPECT_EQ(inside.accuracy, Accuracy::kSurfaceOnly);
  const MotionResult met = Along(world, 0, 1.5);
  EXPECT_EQ(met.verdict, MotionVerdict::kContact);
  EXPECT_EQ(met.accuracy, Accuracy::kSurfaceOnly);
  const MotionResult grazing = Along(world, 0.5, 0.9 - 1e-7);
  EXPECT_EQ(grazing.verdict, MotionVerdict::kGrazing);
  EXPECT_EQ(grazing.accuracy, Accuracy::kSurfaceOnly);
}

TEST(MotionAccuracy, IsThatOfThePairInContact) {
  const MotionResult met = Along(WorldOf({Bin(0), Ball("ball", 0.5)}), 0, 0.8);
  EXPECT_EQ(met.verdict, MotionVerdict::kContact);
  EXPECT_EQ(met.accuracy, Accuracy::kExact);
}

TEST(MotionAccuracy, KnowsNothingOfWhatStaysFarAway) {
  const MotionResult free = Along(WorldOf({Bin(0), Ball("ball", 5)}), 3, 4);
  EXPECT_EQ(free.verdict, MotionVerdict::kFree);
  EXPECT_EQ(free.accuracy, Accuracy::kExact);
}

TEST(MotionAccuracy, OfDoubtIsThatOfThePairThatIsDoubted) {
  Change shadow = Bin(0);
  std::get<PutObject>(shadow.what).kind = ObjectKind::kUnseen;
  const MotionResult through = Along(WorldOf({shadow}), 0, 1.5, {.unseen = UnseenSpace::kReport});
  EXPECT_EQ(through.verdict, MotionVerdict::kUndecided);
  EXPECT_EQ(through.accuracy, Accuracy::kSurfaceOnly);
}

// If two pairs are in contact, the answers for a motion and for a state may name different ones,
// but have the same accuracy.
TEST(MotionAccuracy, IsThatOfTheStatesOnTheWay) {
  std::mt19937 random(7);
  const SnapshotPtr world = RandomWorld(24, random, true);
  const QueryBody body = Gripper();
  std::vector<int> seen(4);
  for (int k = 0; k < 400; ++k) {
    const QueryOptions options = {.margin_m = k % 2 == 0 ? 0 : 0.02};
    Pose from = RandomPose(random, 0.9), to = RandomPose(random, 0.9);
    // Starts in the middle of an object, where the depth, which is only bounded, does not matter.
    const auto middle = static_cast<std::size_t>(k / 4) % world->objects().size();
    if (k % 4 < 2) from.translation() = world->objects()[middle]->X_WO.translation();
    const RigidMotion motion(body, from, to);
    EdgeChecker checker(*world, body, options, {});
    const MotionResult result = checker.Check(motion);
    const bool is_contact = result.verdict == MotionVerdict::kContact;
    const double end = is_contact ? result.hi : 1;
    constexpr int kSteps = 50;
    for (int step = is_contact ? kSteps : 0; step <= kSteps; ++step) {
      Pose X_WB;
      motion.Place(end * step / kSteps, {&X_WB, 1});
      const CollisionColumns state =
          *CheckCollisions(*world, body, std::vector<Pose>{X_WB}, options);
      if (!is_contact) {
        EXPECT_GE(result.accuracy, state.accuracy[0]) << k;
        continue;
      }
      ASSERT_EQ(state.verdict[0], Verdict::kCollision) << k;
      const bool same = state.object[0] == result.object &&
                        state.body_part[0] == result.body_part &&
                        state.object_part[0] == result.object_part;
      if (same) {
        EXPECT_EQ(result.accuracy, state.accuracy[0]) << k;
      }
    }
    ++seen[static_cast<std::size_t>(result.accuracy)];
  }
  EXPECT_GT(seen[static_cast<int>(Accuracy::kExact)], 10);
  EXPECT_EQ(seen[static_cast<int>(Accuracy::kBounded)], 0) << "no margin here is about a depth";
  EXPECT_GT(seen[static_cast<int>(Accuracy::kSurfaceOnly)], 10);
}

std::vector<Accuracy> AccuracyOfPaths(const SnapshotPtr& world, const std::vector<double>& places_m,
                                      const std::vector<Path>& paths) {
  std::vector<Pose> poses;
  for (const double x_m : places_m) poses.push_back(MakeTranslation(x_m, 0, 0));
  const QueryBody body = BallBody();
  return CheckPaths(*world, body, PoseWaypoints(body, poses), paths, {})->accuracy;
}

TEST(MotionAccuracy, OfAPathIsTheWeakestOfItsEdgesUnlessItMeetsSomething) {
  const SnapshotPtr world = WorldOf({Bin(0), Ball("ball", 6)});
  EXPECT_EQ(AccuracyOfPaths(world, {4, 3.5, 4}, {{.row_count = 3}})[0], Accuracy::kExact);
  EXPECT_EQ(AccuracyOfPaths(world, {4, 3, 1.2, 3}, {{.row_count = 4}})[0], Accuracy::kSurfaceOnly);
  EXPECT_EQ(AccuracyOfPaths(world, {1.2, 3, 7}, {{.row_count = 3}})[0],
            Accuracy::kExact);  // at the ball
}

// Spheres only stand for the robot, so no verdict is certain about the robot.
TEST(MotionAccuracy, OfARobotOfSpheresIsDegradedWhateverTheVerdict) {
  const auto model = ThreeBallArm();
  const auto robot = PrepareRobot(model, std::nullopt);
  SphereModel spheres;
  spheres.links.resize(model->links.size());
  spheres.links[static_cast<std::size_t>(*model->FindLink("e"))] = {{.radius_m = 0.1}};
  const SnapshotPtr world =
      WorldOf({PutOf("post", {{.shape = Sphere{0.1}}}, MakeTranslation(0, 1, 0))});
  // The paths are free, through the post at pi / 2, and outside the limits.
  const std::vector<double> states = {0, 0, 1, 0, 1, 0, 2, 0, 0, 0, 3.2, 0};
  const std::vector<Path> paths = {{}, {.first_row = 2}, {.first_row = 4}};
  const JointRows rows(*model, model->all, {.base = DefaultVariables(*model), .rows = states});
  const auto result = [&](const QueryBody& body) {
    return *CheckPaths(*world, body, JointWaypoints(*model, body, rows), paths, {});
  };
  const MotionColumns exact = result(BodyFromRobot(*robot, RobotScope::kBoth));
  EXPECT_EQ(exact.accuracy, std::vector<Accuracy>(3, Accuracy::kExact));
  const MotionColumns of_spheres = result(BodyFromSpheres(*robot, spheres, RobotScope::kBoth));
  EXPECT_EQ(of_spheres.accuracy, std::vector<Accuracy>(3, Accuracy::kDegraded));
  EXPECT_EQ(of_spheres.verdict,
            (std::vector<MotionVerdict>{MotionVerdict::kFree, MotionVerdict::kContact,
                                        MotionVerdict::kOutOfLimits}));
  EXPECT_EQ(exact.verdict, of_spheres.verdict);
}

}  // namespace
}  // namespace cwm::collision
