// Which identities are certain when things of one shape were away.
#include "server/core/live/gone_objects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cwm::server {
namespace {

using collision::WorldObject;
using collision::WorldObjectPtr;
using std::chrono::seconds;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

const Shape kCan = Cylinder{.radius_m = 0.033, .length_m = 0.12};
const Shape kCarton = Box{{0.07, 0.07, 0.2}};

WorldObjectPtr Object(const std::string& name, const Shape& shape) {
  HybridModel model;
  model.shapes.push_back({.X_OS = Pose::Identity(), .shape = shape});
  auto object = std::make_shared<WorldObject>();
  object->name = name;
  object->geometry = collision::Prepare(std::make_shared<const HybridModel>(std::move(model)));
  return object;
}

TEST(GoneObjects, OneThatWasAwayAloneIsItself) {
  GoneObjects gone;
  const perception::Stamp now{std::chrono::hours(1)};
  const WorldObjectPtr can = Object("can", kCan);
  gone.Add(can, now);
  gone.Add(Object("carton", kCarton), now);
  EXPECT_EQ(gone.objects().size(), 2U);
  EXPECT_THAT(gone.SeenAgain(*can, {}), IsEmpty());
  EXPECT_TRUE(gone.IsCertain("can"));
  EXPECT_EQ(gone.objects().size(), 1U);
}

TEST(GoneObjects, OneOfTwoTwinsThatWereAwayMayBeTheOther) {
  GoneObjects gone;
  const perception::Stamp now{std::chrono::hours(1)};
  const WorldObjectPtr can_1 = Object("can_1", kCan);
  const WorldObjectPtr can_2 = Object("can_2", kCan);
  gone.Add(can_1, now);
  gone.Add(can_2, now);
  gone.Add(Object("carton", kCarton), now);
  EXPECT_THAT(gone.SeenAgain(*can_2, {}), UnorderedElementsAre("can_1", "can_2"));
  EXPECT_FALSE(gone.IsCertain("can_2"));
  EXPECT_TRUE(gone.IsCertain("carton"));
  // The other one comes back alone, and may still be the first.
  EXPECT_THAT(gone.SeenAgain(*can_1, {}), IsEmpty());
  EXPECT_FALSE(gone.IsCertain("can_1"));
}

TEST(GoneObjects, ATwinThatIsLostMayBeTheOneThatIsSeen) {
  GoneObjects gone;
  const WorldObjectPtr lost[] = {Object("can_1", kCan), Object("carton", kCarton)};
  const WorldObjectPtr can_2 = Object("can_2", kCan);
  gone.Add(can_2, perception::Stamp());
  EXPECT_THAT(gone.SeenAgain(*can_2, lost), UnorderedElementsAre("can_1", "can_2"));
  EXPECT_FALSE(gone.IsCertain("can_1"));
}

TEST(GoneObjects, WhatIsAwayForLongIsForgotten) {
  GoneObjects gone;
  const perception::Stamp now{std::chrono::hours(1)};
  const WorldObjectPtr can_1 = Object("can_1", kCan);
  gone.Add(can_1, now);
  gone.Add(Object("can_2", kCan), now + seconds(50));
  gone.ForgetAfter(seconds(60), now + seconds(61));
  ASSERT_EQ(gone.objects().size(), 1U);
  EXPECT_EQ(gone.objects().front()->name, "can_2");
}

}  // namespace
}  // namespace cwm::server
