#include "perception/refinement/attach/attach_handles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "perception/handles/vessel_handles.h"
#include "perception/hypotheses/invariants.h"
#include "tests/perception/model/vessels.h"

namespace cwm::perception {
namespace {

// A mug on a table at z = 0; everything that a test adds becomes an object hypothesis of its own.
class CutOff : public ::testing::Test {
 protected:
  CutOff() {
    scene_.points.viewpoint = Vector3(-0.6, 0, 0.6);
    Placed<Plate> table;
    table.shape.outline = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    table.shape.thickness_m = 0.02;
    scene_.supports.push_back({table, {}});
    AddMug(Vector2::Zero(), scene_.points);
    AddHypothesis(0);
    mug_points_ = scene_.points.size();
  }

  void AddHypothesis(std::int32_t supported_by) {
    SegmentedHypothesis& hypothesis = scene_.hypotheses.emplace_back();
    hypothesis.supported_by = supported_by;
    for (; known_ < scene_.points.size(); ++known_) hypothesis.points.push_back(known_);
    hypothesis.node_count = hypothesis.points.size();
  }

  // Attaches the handles found; false if not all pairs could be examined.
  bool AttachAll() {
    state_.emplace(scene_);
    const FoundHandles found = FindCutOffHandles(*state_, kSerialWork);
    state_ = Attach(*state_, found.transfers);
    EXPECT_THAT(ViolatedInvariants(*state_), ::testing::IsEmpty());
    return found.all_searched;
  }
  std::size_t Count() const { return state_->hypotheses().size(); }
  const ObjectHypothesis& At(std::size_t k) const { return *state_->hypotheses()[k]; }

  SegmentedScene scene_;
  std::optional<SceneState> state_;
  std::uint32_t known_ = 0;
  std::size_t mug_points_ = 0;
};

TEST_F(CutOff, AnEarReturnsToItsMug) {
  AddTube(Ear(), 0.01, scene_.points);
  AddHypothesis(-1);
  EXPECT_TRUE(AttachAll());
  ASSERT_EQ(Count(), 1u);
  EXPECT_EQ(At(0).points.size(), scene_.points.size());
  EXPECT_EQ(At(0).node_count, scene_.points.size());
  EXPECT_EQ(At(0).resting.support, 0);
}

TEST_F(CutOff, APenThatStandsBesideItStaysAnObject) {
  AddTube({{0, kMugRadius_m + 0.02, 0}, {0, kMugRadius_m + 0.03, 0.12}}, 0.01, scene_.points);
  AddHypothesis(0);
  EXPECT_TRUE(AttachAll());
  EXPECT_EQ(Count(), 2u);
}

TEST_F(CutOff, AnEarThatABoxTookReturnsAndTheBoxStays) {
  AddTube(Ear(), 0.01, scene_.points);
  const std::size_t of_mug_and_ear = scene_.points.size();
  // A face of 64 x 100 mm that touches the ear where it reaches out farthest.
  for (double y = kMugRadius_m + 0.036; y < kMugRadius_m + 0.1; y += 0.002) {
    AddTube({{0, y, 0}, {0, y, 0.1}}, 0.002, scene_.points);
  }
  AddHypothesis(0);
  EXPECT_TRUE(AttachAll());
  ASSERT_EQ(Count(), 2u);
  const std::size_t all = scene_.points.size();
  EXPECT_EQ(At(0).points.size() + At(1).points.size(), all);
  EXPECT_EQ(At(0).node_count + At(1).node_count, all);
  // Points within a finger's width of the box stay with the box, the ear's among them.
  const bool second_is_box = At(1).points.back() == all - 1;
  const PointSet& mug = At(second_is_box ? 0 : 1).points;
  EXPECT_GE(mug.size(), mug_points_ + kMinHandlePoints);
  EXPECT_LE(
      std::count_if(mug.begin(), mug.end(), [&](std::uint32_t i) { return i >= of_mug_and_ear; }),
      static_cast<std::ptrdiff_t>(kMinHandlePoints));
}

TEST_F(CutOff, APieceOfTheWallReturnsWithItsEar) {
  AddTube(Ear(), 0.01, scene_.points);
  AddHypothesis(0);
  PointSet& mug = scene_.hypotheses[0].points;
  PointSet& piece = scene_.hypotheses[1].points;
  // The part of the wall on the ear's side belongs to the segment as well.
  const auto is_near_ear = [&](std::uint32_t i) { return scene_.points.points[i].y() > 0.03f; };
  std::copy_if(mug.begin(), mug.end(), std::back_inserter(piece), is_near_ear);
  std::erase_if(mug, is_near_ear);
  EXPECT_TRUE(AttachAll());
  ASSERT_EQ(Count(), 1u);
  EXPECT_EQ(At(0).points.size(), scene_.points.size());
}

TEST_F(CutOff, WhatRestsOnTheEarRestsOnTheMug) {
  AddTube(Ear(), 0.01, scene_.points);
  AddHypothesis(0);
  // A post, far from the mug; its attachment is not examined.
  AddTube({{0.5, 0, 0.02}, {0.5, 0, 0.06}}, 0.04, scene_.points);
  AddHypothesis(0);
  scene_.hypotheses[2].rests_on = 1;
  scene_.hypotheses[1].rests_on = 0;
  EXPECT_TRUE(AttachAll());
  ASSERT_EQ(Count(), 2u);
  EXPECT_FALSE(At(0).resting.on);
  EXPECT_EQ(At(1).resting.on, At(0).id);
}

// Sixteen objects in one place make more pairs than any kitchen has.
TEST_F(CutOff, ACrowdIsNotLookedAtInAllPairsAndLosesNothing) {
  for (int k = 1; k < 16; ++k) {
    AddMug(Vector2::Zero(), scene_.points);
    AddHypothesis(0);
  }
  EXPECT_FALSE(AttachAll());
  std::size_t points = 0;
  for (const HypothesisPtr& hypothesis : state_->hypotheses()) points += hypothesis->points.size();
  EXPECT_EQ(points, scene_.points.size());
}

}  // namespace
}  // namespace cwm::perception
