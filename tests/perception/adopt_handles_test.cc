#include "perception/adopt_handles.h"

#include <gtest/gtest.h>

#include "tests/perception/model/vessels.h"

namespace cwm::perception {
namespace {

// A mug on a table at z = 0; whatever else is added becomes a thing of its own.
class CutOff : public ::testing::Test {
 protected:
  CutOff() {
    scene_.points.viewpoint = Vector3(-0.6, 0, 0.6);
    Placed<Plate> table;
    table.shape.outline = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    table.shape.thickness_m = 0.02;
    scene_.supports.push_back({table, {}});
    AddMug(Vector2::Zero(), scene_.points);
    AddThing(0);
  }

  void AddThing(std::int32_t supported_by) {
    SegmentedThing& thing = scene_.things.emplace_back();
    thing.supported_by = supported_by;
    for (; known_ < scene_.points.size(); ++known_) thing.points.push_back(known_);
    thing.node_count = thing.points.size();
  }

  SegmentedScene scene_;
  std::uint32_t known_ = 0;
};

TEST_F(CutOff, AnEarReturnsToItsMug) {
  AddTube(Ear(), 0.01, scene_.points);
  AddThing(-1);
  AdoptHandles(scene_, kUnbounded);
  ASSERT_EQ(scene_.things.size(), 1u);
  EXPECT_EQ(scene_.things[0].points.size(), scene_.points.size());
  EXPECT_EQ(scene_.things[0].node_count, scene_.points.size());
  EXPECT_EQ(scene_.things[0].supported_by, 0);
}

TEST_F(CutOff, APenThatStandsBesideItStaysAThing) {
  AddTube({{0, kMugRadius_m + 0.02, 0}, {0, kMugRadius_m + 0.03, 0.12}}, 0.01, scene_.points);
  AddThing(0);
  AdoptHandles(scene_, kUnbounded);
  EXPECT_EQ(scene_.things.size(), 2u);
}

TEST_F(CutOff, WhatRestsOnTheEarRestsOnTheMug) {
  AddTube(Ear(), 0.01, scene_.points);
  AddThing(0);
  // A post, far off: where it is, is not asked.
  AddTube({{0.5, 0, 0.02}, {0.5, 0, 0.06}}, 0.04, scene_.points);
  AddThing(0);
  scene_.things[2].rests_on = 1;
  scene_.things[1].rests_on = 0;
  AdoptHandles(scene_, kUnbounded);
  ASSERT_EQ(scene_.things.size(), 2u);
  EXPECT_EQ(scene_.things[0].rests_on, -1);
  EXPECT_EQ(scene_.things[1].rests_on, 0);
}

}  // namespace
}  // namespace cwm::perception
