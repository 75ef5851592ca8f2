// Motions of robots with attached objects, and of objects on supports, against dense samples.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "collision/motion/check_paths.h"
#include "collision/query/attached_objects.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/robot/robot_text.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::collision {
namespace {

using testing::Arm;
using ::testing::ElementsAre;
using testing::MakeChange;
using SnapshotPtr = std::shared_ptr<const WorldSnapshot>;

constexpr int kSamples = 400;  // per edge

// The three balls of robot_text.h; a long box is attached to the last one, far from its link.
SnapshotPtr WithBox(const SnapshotPtr& world) {
  const std::vector<Change> changes = {
      MakeChange(testing::PutArm(
          "arm", Arm(testing::Robot(testing::ThreeBalls()), "<robot name=\"r\"/>"))),
      PutOf("box", {{.X_FS = MakeTranslation(0, 0.1, 0), .shape = Box{{0.05, 0.4, 0.05}}}},
            Pose::Identity()),
      MakeChange(AttachObject{.name = "box",
                              .robot = "arm",
                              .link = "e",
                              .X_LO = MakeTranslation(0.2, 0, 0),
                              .touch_links = {}})};
  auto next = Apply(world, changes);
  EXPECT_TRUE(next.ok()) << next.status();
  return *next;
}

std::vector<double> Between(std::span<const double> from, std::span<const double> to,
                            double share) {
  std::vector<double> row;
  for (std::size_t v = 0; v < from.size(); ++v) row.push_back(from[v] + share * (to[v] - from[v]));
  return row;
}

TEST(AttachedMotions, AreNeverWrongByDenseSamples) {
  std::mt19937 random(5);
  const SnapshotPtr world = WithBox(RandomWorld(14, random, true));
  const WorldRobotPtr robot = world->FindRobot("arm");
  ASSERT_NE(robot, nullptr);
  const QueryBody body = WithAttachedObjects(BodyFromRobot(*robot, RobotScope::kBoth), *world,
                                             *robot, RobotScope::kBoth);
  ASSERT_EQ(body.attached.size(), 1u);
  const JointGroup& group = robot->model().all;
  const std::size_t width = group.variables.size();
  std::uniform_real_distribution<double> angle(-2.5, 2.5), step(-0.8, 0.8);
  std::vector<double> rows;
  std::vector<Path> paths;
  for (std::size_t k = 0; k < 150; ++k) {
    for (std::size_t v = 0; v < width; ++v) rows.push_back(angle(random));
    for (std::size_t v = 0; v < width; ++v)
      rows.push_back(rows[rows.size() - width] + step(random));
    paths.push_back({.first_row = 2 * k});
  }
  const auto states_of = [&](std::span<const double> some) {
    return JointRows(robot->model(), group,
                     {.X_WB = robot->X_WB, .base = robot->state, .rows = some});
  };
  const JointRows states = states_of(rows);
  const JointWaypoints waypoints(robot->model(), body, states);
  const MotionColumns result = *CheckPaths(*world, body, waypoints, paths, {});
  int free = 0, contacts = 0, of_box = 0;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    if (result.verdict[k] == MotionVerdict::kOutOfLimits) continue;
    const auto from = std::span<const double>(rows).subspan(2 * k * width, width);
    const auto to = std::span<const double>(rows).subspan((2 * k + 1) * width, width);
    const bool is_contact = result.verdict[k] == MotionVerdict::kContact;
    ASSERT_TRUE(is_contact || result.verdict[k] == MotionVerdict::kFree) << k;
    const double certain_to = is_contact ? result.lo[k] : 1;
    std::vector<double> samples;
    for (int i = 0; i <= kSamples; ++i) {
      const double share = certain_to * i / kSamples;
      const std::vector<double> row = Between(from, to, share);
      samples.insert(samples.end(), row.begin(), row.end());
    }
    if (certain_to > 0 || !is_contact) {
      const auto sampled = *CheckCollisions(*world, body, states_of(samples), {});
      for (const Verdict verdict : sampled.verdict) EXPECT_NE(verdict, Verdict::kCollision) << k;
      ++free;
    }
    if (!is_contact) continue;
    const std::vector<double> met = Between(from, to, result.hi[k]);
    EXPECT_EQ(CheckCollisions(*world, body, states_of(met), {})->verdict[0], Verdict::kCollision);
    ++contacts;
    of_box += body.AttachedIn(body.FrameOf(result.body_part[k])) != nullptr ? 1 : 0;
  }
  EXPECT_GT(free, 30);
  EXPECT_GT(contacts, 15);
  EXPECT_GT(of_box, 5) << "the box is what meets the world now and then";
}

// A cup of 0.1 m that is `deep_m` deep in its table and moves along `way`.
MotionColumns CupOnTable(double deep_m, const Vector3& way, const QueryOptions& options = {}) {
  Change cup = PutOf("cup", {{.X_FS = Pose::Identity(), .shape = Cylinder{0.03, 0.1}}},
                     MakeTranslation(0, 0, 0.05 - deep_m));
  std::get<PutObject>(cup.what).supported_by = "table";
  const SnapshotPtr world =
      WorldOf({cup, PutOf("table", {{.X_FS = Pose::Identity(), .shape = Box{{1, 1, 0.04}}}},
                          MakeTranslation(0, 0, -0.02))});
  const WorldObjectPtr object = world->Find("cup");
  const QueryBody body = BodyFromObject(*object);
  const std::vector<Pose> poses = {object->X_WO, Pose(Eigen::Translation3d(way)) * object->X_WO};
  const std::vector<Path> paths = {{.row_count = 2}};
  return *CheckPaths(*world, body, PoseWaypoints(body, poses), paths, options);
}

TEST(SupportTolerance, LetsGoOfWhatAnObjectStandsIn) {
  EXPECT_THAT(CupOnTable(0.003, {0, 0, 0.2}).verdict, ElementsAre(MotionVerdict::kFree));
  EXPECT_THAT(CupOnTable(0.003, {0.1, 0, 0}).verdict, ElementsAre(MotionVerdict::kFree));
  EXPECT_NEAR(CupOnTable(0.003, {0.1, 0, 0}).clearance_m[0], 0.002, 2e-3);
  EXPECT_LE(CupOnTable(0.003, {0.1, 0, 0}).clearance_m[0], 0.002 + 1e-7);
  EXPECT_THAT(CupOnTable(0.0051, {0, 0, 0.2}).verdict, ElementsAre(MotionVerdict::kContact));
  QueryOptions options;
  options.support_tolerance_m = 0;
  EXPECT_THAT(CupOnTable(0.003, {0, 0, 0.2}, options).verdict,
              ElementsAre(MotionVerdict::kContact));
}

TEST(SupportTolerance, EndsAtItsDepth) {
  const MotionColumns result = CupOnTable(0.001, {0, 0, -0.02});
  ASSERT_THAT(result.verdict, ElementsAre(MotionVerdict::kContact));
  const double met = 0.004 / 0.02;  // at a depth of 5 mm
  EXPECT_LE(result.lo[0], met);
  EXPECT_GE(result.hi[0], met - 1e-6);
  EXPECT_LE(result.hi[0] - result.lo[0], kMaxBracketWidth + 1e-12);
}

}  // namespace
}  // namespace cwm::collision
