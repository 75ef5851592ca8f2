// Compiled programs that are kept are found for an equal query, and never for another.
#include "collision/spheres/program_cache.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "collision/robot/urdf.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using testing::JointText;
using testing::Links;
using testing::NoMeshes;
using testing::Robot;

class ProgramMemoTest : public ::testing::Test {
 protected:
  ProgramMemoTest() {
    const std::string axis = "<axis xyz=\"0 1 0\"/><limit lower=\"-2\" upper=\"2\"/>";
    const auto description =
        ReadUrdf(Robot(Links("abc") + JointText("one", "revolute", "a", "b", axis) +
                       JointText("two", "revolute", "b", "c", axis)),
                 NoMeshes);
    EXPECT_TRUE(description.ok()) << description.status();
    model_ = *MakeRobotModel(*description, nullptr);
    memo_ = std::make_unique<ProgramCache>(*model_);
    arm_.variables = {1};
  }

  std::shared_ptr<const SphereProgram> Find() {
    return memo_->Find(arm_, base_,
                       {.spheres = spheres_,
                        .fixed_frames = fixed_frames_,
                        .pairs = {.spheres = pairs_, .links = links_}});
  }
  std::shared_ptr<const SphereProgram> FindWithMargin(double margin_m) {
    const auto before = std::exchange(pairs_[0].margin_m, margin_m);
    auto found = Find();
    pairs_[0].margin_m = before;
    return found;
  }

  std::shared_ptr<const RobotModel> model_;
  std::unique_ptr<ProgramCache> memo_;
  JointGroup arm_;
  std::vector<double> base_ = {0.1, 0.2};
  std::vector<PlacedSphere> spheres_ = {{.link = 0, .centre_L = {0, 0, 1}, .radius_m = 0.1},
                                        {.link = 2, .centre_L = {0, 0, 0}, .radius_m = 0.2}};
  std::vector<FixedFrame> fixed_frames_ = {{.link = 2, .X_LF = Pose::Identity()}};
  std::vector<SpherePair> pairs_ = {{.first = 0, .second = 1}};
  std::vector<SphereLinkPair> links_;
};

TEST_F(ProgramMemoTest, FindsTheSameForTheSameQuestionWhateverTheGroupsOwnValues) {
  const auto first = Find();
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->lanes.spheres.size(), 2u);
  EXPECT_EQ(Find(), first);
  base_[1] = 1.5;  // comes from the rows
  EXPECT_EQ(Find(), first);
}

TEST_F(ProgramMemoTest, FindsAnotherWhereAnythingDiffers) {
  const auto first = Find();
  const auto expect_another = [&](const char* what, auto& changed, const auto& value) {
    auto before = std::exchange(changed, value);
    EXPECT_NE(Find(), first) << what;
    changed = std::move(before);
    EXPECT_EQ(Find(), first) << what;
  };
  expect_another("base", base_[0], 0.5);
  expect_another("group", arm_.variables, std::vector<int>{0});
  expect_another("radius", spheres_[1].radius_m, 0.25);
  expect_another("centre", spheres_[1].centre_L, Vector3(0, 0.1, 0));
  expect_another("link of a sphere", spheres_[1].link, 1);
  expect_another("fixed frame", fixed_frames_[0].X_LF, Pose(Eigen::Translation3d(0, 0, 0.1)));
  expect_another("link of a frame", fixed_frames_[0].link, 1);
  expect_another("pairs of spheres", pairs_, std::vector<SpherePair>());
  expect_another("proof", spheres_[1].proof, LaneProof{.of_contact = false});
  expect_another("class", spheres_[1].scene_class, 1);
  expect_another("margin of a pair", pairs_[0].margin_m, 0.01);
  expect_another("tag of a pair", pairs_[0].tag, 1);
  expect_another("pairs of links", links_, std::vector<SphereLinkPair>{{.links = {0, 2}}});
}

TEST_F(ProgramMemoTest, ForgetsWhatWasAskedForLongestAgo) {
  const auto first = Find();
  const auto second = FindWithMargin(0.001);
  for (int k = 2; k < 8; ++k) FindWithMargin(0.001 * k);
  EXPECT_EQ(Find(), first);  // now the newest
  FindWithMargin(0.1);
  EXPECT_EQ(Find(), first);
  EXPECT_NE(FindWithMargin(0.001), second);
}

TEST_F(ProgramMemoTest, GivesAllThreadsTheSame) {
  std::vector<std::shared_ptr<const SphereProgram>> found(8);
  std::vector<std::thread> threads;
  for (auto& each : found) threads.emplace_back([&] { each = Find(); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& each : found) EXPECT_EQ(each, found[0]);
}

}  // namespace
}  // namespace cwm::collision
