#include "perception/refinement/attach/attachment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "perception/hypotheses/invariants.h"

namespace cwm::perception {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Four objects of two points each; each rests on the one before.
SceneState Tower() {
  SegmentedScene scene;
  scene.points.points.resize(8);
  scene.supports.emplace_back();
  for (std::uint32_t k = 0; k < 4; ++k) {
    SegmentedHypothesis& hypothesis = scene.hypotheses.emplace_back();
    hypothesis.supported_by = 0;
    hypothesis.points = {2 * k, 2 * k + 1};
    hypothesis.node_count = 2;
    hypothesis.rests_on = static_cast<std::int32_t>(k) - 1;
  }
  return SceneState(std::move(scene));
}

TEST(Attach, GivesAllAndWhatRestedOnItRestsOnTheReceiver) {
  const SceneState before = Tower();
  const std::vector<PointTransfer> transfers = {{{1}, {0}, {}}};
  const SceneState after = Attach(before, transfers);
  EXPECT_THAT(ViolatedInvariants(after), IsEmpty());
  EXPECT_THAT(after.hypotheses(), SizeIs(3));
  const HypothesisId receiver = before.NextId(0);
  EXPECT_THAT(after.Get(receiver).points, ElementsAre(0, 1, 2, 3));
  EXPECT_FALSE(after.Get(receiver).resting.on);
  EXPECT_EQ(after.Get({2}).resting.on, receiver);
}

TEST(Attach, GivesWhatWasGivenOn) {
  const SceneState before = Tower();
  const std::vector<PointTransfer> transfers = {{{2}, {1}, {}}, {{1}, {0}, {}}};
  const SceneState after = Attach(before, transfers);
  EXPECT_THAT(ViolatedInvariants(after), IsEmpty());
  EXPECT_THAT(after.Get(before.NextId(0)).points, ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(Attach, GivesAPart) {
  const SceneState before = Tower();
  const std::vector<PointTransfer> transfers = {{{3}, {0}, {7}}};
  const SceneState after = Attach(before, transfers);
  EXPECT_THAT(ViolatedInvariants(after), IsEmpty());
  EXPECT_THAT(after.hypotheses(), SizeIs(4));
  EXPECT_THAT(after.Get(before.NextId(0)).points, ElementsAre(0, 1, 7));
  EXPECT_THAT(after.Get(before.NextId(1)).points, ElementsAre(6));
  EXPECT_EQ(after.Get(before.NextId(1)).resting.on, HypothesisId{2});
  EXPECT_EQ(after.Get({1}).resting.on, before.NextId(0));
}

TEST(Attach, ChangesNothingWithoutGifts) {
  const SceneState before = Tower();
  const SceneState after = Attach(before, {});
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(after.hypotheses()[k], before.hypotheses()[k]);
}

}  // namespace
}  // namespace cwm::perception
