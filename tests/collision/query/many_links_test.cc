// A robot of 500 links: more than there are tag bits, each of which then stands for several links
// and pairs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "collision/query/robot_body.h"
#include "collision/query/sphere_check.h"
#include "collision/robot/kinematics.h"
#include "tests/collision/query/plain_rows.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using testing::JointText;
using testing::NoMeshes;
using testing::Robot;

constexpr int kLinks = 500, kBoxEvery = 5;

std::string NameOfLink(int k) { return "link" + std::to_string(k); }

// A snake of 500 links of 2 cm that turn about z and y alternately; every fifth has a box.
std::string Snake() {
  std::string text;
  for (int k = 0; k < kLinks; ++k) {
    const char box[] =
        "<collision><origin xyz=\"0.01 0 0\"/><geometry><box size=\"0.04 0.03 0.02\"/></geometry>"
        "</collision>";
    text += "<link name=\"" + NameOfLink(k) + "\">" + (k % kBoxEvery == 0 ? box : "") + "</link>\n";
  }
  for (int k = 1; k < kLinks; ++k) {
    text +=
        JointText("joint" + std::to_string(k), "revolute", NameOfLink(k - 1), NameOfLink(k),
                  std::string("<origin xyz=\"0.02 0 0\"/><axis xyz=\"") +
                      (k % 2 == 0 ? "0 0 1" : "0 1 0") + "\"/><limit lower=\"-1\" upper=\"1\"/>");
  }
  return Robot(text);
}

class ManyLinks : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto description = ReadUrdf(Snake(), NoMeshes);
    ASSERT_TRUE(description.ok()) << description.status();
    model_ = *MakeRobotModel(*description, nullptr);
    robot_ = PrepareRobot(model_, std::nullopt);
    std::mt19937 random(5);
    std::vector<Change> changes;
    for (int k = 0; k < 30; ++k) {
      changes.push_back(PutOf("box" + std::to_string(k),
                              {{.X_FS = Pose::Identity(), .shape = Box{{0.1, 0.2, 0.1}}}},
                              RandomPose(random, 4)));
    }
    world_ = WorldOf(changes);
    // Bent slightly, always the same way: from stretched out to rolled up.
    std::vector<double> rows;
    for (int row = 0; row < kRows; ++row) {
      std::normal_distribution<double> bend(0.04 * row / kRows, 0.03 * row / kRows);
      for (std::size_t k = 0; k < model_->variables.size(); ++k) rows.push_back(bend(random));
    }
    rows_ = rows;
  }

  static constexpr int kRows = 400;
  std::shared_ptr<const RobotModel> model_;
  std::shared_ptr<const RobotGeometry> robot_;
  std::shared_ptr<const WorldSnapshot> world_;
  std::vector<double> rows_;
};

TEST_F(ManyLinks, AreLoadedWhole) {
  EXPECT_EQ(model_->links.size(), 500u);
  EXPECT_EQ(model_->variables.size(), 499u);
  EXPECT_EQ(robot_->geometry->parts.size(), 100u);
  EXPECT_GT(model_->self_pairs.size(), 64u);
}

TEST_F(ManyLinks, HaveThePlainVerdictsAndPairs) {
  const JointRows rows(*model_, model_->all, {.base = DefaultVariables(*model_), .rows = rows_});
  for (const RobotScope scope : {RobotScope::kWorld, RobotScope::kSelf, RobotScope::kBoth}) {
    const QueryBody body = BodyFromRobot(*robot_, scope);
    ASSERT_TRUE(SphereCheck::Make(*world_, body, rows, {}).has_value());
    const CollisionColumns plain = *CheckCollisions(*world_, body, PlainRows(rows), {});
    EXPECT_GT(std::ranges::count(plain.verdict, Verdict::kFree), kRows / 20);
    EXPECT_GT(std::ranges::count(plain.verdict, Verdict::kCollision), kRows / 20);
    const CollisionColumns in_lanes = *CheckCollisions(*world_, body, rows, {});
    EXPECT_EQ(in_lanes.verdict, plain.verdict);
    EXPECT_EQ(in_lanes.object, plain.object);
    EXPECT_EQ(in_lanes.body_part, plain.body_part);
    EXPECT_EQ(in_lanes.object_part, plain.object_part);
    EXPECT_EQ(in_lanes.accuracy, plain.accuracy);
  }
}

// If the spheres are the robot itself, the SIMD code also reports collisions.
TEST_F(ManyLinks, OfSpheresHaveThePlainVerdicts) {
  const JointRows rows(*model_, model_->all, {.base = DefaultVariables(*model_), .rows = rows_});
  SphereModel spheres;
  for (const ModelLink& link : model_->links) {
    spheres.links.emplace_back(link.collisions.size(), LinkSphere{.radius_m = 0.03});
  }
  const QueryBody body = BodyFromSpheres(*robot_, spheres, RobotScope::kBoth);
  const QueryOptions options{.naming = Naming::kWhereTested};
  const CollisionColumns plain = *CheckCollisions(*world_, body, PlainRows(rows), options);
  EXPECT_GT(std::ranges::count(plain.verdict, Verdict::kCollision), kRows / 20);
  EXPECT_EQ(CheckCollisions(*world_, body, rows, options)->verdict, plain.verdict);
}

}  // namespace
}  // namespace cwm::collision
