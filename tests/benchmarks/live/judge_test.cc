#include "tests/benchmarks/live/judge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cwm::benchmarks {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kDiagonal_m = 0.1;
constexpr double kPeriod_s = 0.1;

TrueThing ThingAt(double x_m) {
  return {.X_WO = MakeTranslation(x_m, 0, 0),
          .center_W = Vector3(x_m, 0, 0),
          .diagonal_m = kDiagonal_m};
}

TrueThing Absent() {
  TrueThing thing = ThingAt(0);
  thing.is_present = false;
  thing.visible_share = 0;
  return thing;
}

PublishedThing ObjectAt(double x_m, const std::string& name) {
  return {.name = name,
          .X_WO = MakeTranslation(x_m, 0, 0),
          .center_W = Vector3(x_m, 0, 0),
          .diagonal_m = kDiagonal_m,
          .geometry_revision = 1};
}

// One thing; each moment has its truth and what is published.
class TimelineOfOne {
 public:
  TimelineOfOne& Then(int count, const TrueThing& thing,
                      const std::vector<PublishedThing>& published) {
    for (int i = 0; i < count; ++i) {
      timeline_.push_back({.stamp_s = kPeriod_s * static_cast<double>(timeline_.size()),
                           .truth = {thing},
                           .published = published});
    }
    return *this;
  }
  operator const Timeline&() const { return timeline_; }  // NOLINT: reads as the timeline it is

 private:
  Timeline timeline_;
};

TEST(Match, TakesTheNearestObjectOfAboutTheSameSize) {
  PublishedThing large = ObjectAt(0.51, "large");
  large.diagonal_m = 5 * kDiagonal_m;
  const Moment moment{.truth = {ThingAt(0), ThingAt(0.5)},
                      .published = {ObjectAt(0.03, "b"), ObjectAt(0.01, "a"), large}};
  EXPECT_THAT(MatchThings(moment), ElementsAre(1, -1));
}

TEST(Match, NeverTakesMoversAndAbsentThings) {
  PublishedThing mover = ObjectAt(0, "mover_1");
  mover.kind = PublishedKind::kMover;
  EXPECT_THAT(MatchThings({.truth = {ThingAt(0)}, .published = {mover}}), ElementsAre(-1));
  EXPECT_THAT(MatchThings({.truth = {Absent()}, .published = {ObjectAt(0, "a")}}), ElementsAre(-1));
}

TEST(Changes, ATrackerThatInventsIsUnfounded) {
  const auto timeline = TimelineOfOne()
                            .Then(20, ThingAt(0), {ObjectAt(0, "a")})
                            .Then(1, ThingAt(0), {ObjectAt(0, "a"), ObjectAt(0.3, "ghost")})
                            .Then(20, ThingAt(0), {ObjectAt(0, "a")});
  const ChangeVerdict verdict = JudgeChanges(timeline, 0);
  EXPECT_EQ(verdict.unfounded.added, 1);
  EXPECT_EQ(verdict.unfounded.removed, 1);
  EXPECT_EQ(verdict.all.sum(), 2);
  EXPECT_THAT(verdict.lines, SizeIs(2));
}

TEST(Changes, AThingAtRestThatIsReplacedOrMovedIsUnfounded) {
  PublishedThing refitted = ObjectAt(0.001, "a");
  refitted.geometry_revision = 2;
  const auto timeline = TimelineOfOne()
                            .Then(20, ThingAt(0), {ObjectAt(0, "a")})
                            .Then(5, ThingAt(0), {ObjectAt(0.001, "a")})
                            .Then(5, ThingAt(0), {refitted});
  const ChangeVerdict verdict = JudgeChanges(timeline, 0);
  EXPECT_EQ(verdict.unfounded.moved, 1);
  EXPECT_EQ(verdict.unfounded.replaced, 1);
}

TEST(Changes, WhatFollowsFromATrueEventIsFounded) {
  const auto timeline = TimelineOfOne()
                            .Then(20, Absent(), {})
                            .Then(5, ThingAt(0), {})
                            .Then(20, ThingAt(0), {ObjectAt(0, "a")})
                            .Then(2, ThingAt(0.02), {ObjectAt(0, "a")})
                            .Then(20, ThingAt(0.02), {ObjectAt(0.02, "a")})
                            .Then(2, Absent(), {ObjectAt(0.02, "a")})
                            .Then(20, Absent(), {});
  const ChangeVerdict verdict = JudgeChanges(timeline, 0);
  EXPECT_EQ(verdict.all.added, 1);
  EXPECT_EQ(verdict.all.moved, 1);
  EXPECT_EQ(verdict.all.removed, 1);
  EXPECT_EQ(verdict.unfounded.sum(), 0) << ::testing::PrintToString(verdict.lines);
}

TEST(Changes, WhatMovesLongAfterItsThingDidIsUnfounded) {
  const auto timeline = TimelineOfOne()
                            .Then(5, ThingAt(0), {ObjectAt(0, "a")})
                            .Then(30, ThingAt(0.03), {ObjectAt(0, "a")})
                            .Then(5, ThingAt(0.03), {ObjectAt(0.03, "a")});
  EXPECT_EQ(JudgeChanges(timeline, 0).unfounded.moved, 1);
}

TEST(Notices, ATrackerThatDoesNothingNoticesNothing) {
  const auto timeline = TimelineOfOne()
                            .Then(5, Absent(), {})
                            .Then(10, ThingAt(0), {})
                            .Then(10, ThingAt(0.05), {})
                            .Then(10, Absent(), {});
  const auto notices = JudgeNotices(timeline, 0);
  ASSERT_THAT(notices, SizeIs(3));
  EXPECT_FALSE(notices[0].moments);
  EXPECT_FALSE(notices[1].moments);
  EXPECT_FALSE(notices[2].moments);
}

TEST(Notices, CountMomentsFromTheFirstThatShowsTheEvent) {
  PublishedThing moving = ObjectAt(0.001, "a");
  moving.is_moving = true;
  PublishedThing piece = ObjectAt(0, "mover_1");
  piece.kind = PublishedKind::kMover;
  const auto timeline = TimelineOfOne()
                            .Then(5, Absent(), {})
                            .Then(2, ThingAt(0), {})
                            .Then(3, ThingAt(0), {piece})
                            .Then(10, ThingAt(0), {ObjectAt(0, "a")})
                            .Then(1, ThingAt(0.02), {ObjectAt(0, "a")})
                            .Then(9, ThingAt(0.02), {moving})
                            .Then(3, Absent(), {ObjectAt(0.02, "a")})
                            .Then(9, Absent(), {});
  const auto notices = JudgeNotices(timeline, 0);
  ASSERT_THAT(notices, SizeIs(3));
  EXPECT_EQ(notices[0].kind, Notice::Kind::kAdded);
  EXPECT_EQ(notices[0].moments, 2);
  EXPECT_EQ(notices[1].kind, Notice::Kind::kMoved);
  EXPECT_EQ(notices[1].moments, 1);
  EXPECT_NEAR(notices[1].distance_m, 0.02, 1e-12);
  EXPECT_NEAR(*notices[1].time_s, kPeriod_s, 1e-12);
  EXPECT_EQ(notices[2].kind, Notice::Kind::kRemoved);
  EXPECT_EQ(notices[2].moments, 3);
}

TEST(Notices, LargeObjectsAndOnesThatWereThereBeforeAreNoNotice) {
  PublishedThing large = ObjectAt(0, "cupboard");
  large.diagonal_m = 9 * kDiagonal_m;
  const auto timeline = TimelineOfOne()
                            .Then(5, Absent(), {large, ObjectAt(0.01, "ghost")})
                            .Then(5, ThingAt(0), {large, ObjectAt(0.01, "ghost")})
                            .Then(5, Absent(), {large, ObjectAt(0.01, "ghost")});
  const auto notices = JudgeNotices(timeline, 0);
  ASSERT_THAT(notices, SizeIs(2));
  EXPECT_FALSE(notices[0].moments);
  EXPECT_FALSE(notices[1].moments);
}

TEST(Notices, AMoveOverSeveralMomentsIsOneEvent) {
  TimelineOfOne timeline;
  timeline.Then(5, ThingAt(0), {ObjectAt(0, "a")});
  for (int i = 1; i <= 4; ++i) timeline.Then(1, ThingAt(0.01 * i), {ObjectAt(0.01 * i, "a")});
  timeline.Then(5, ThingAt(0.04), {ObjectAt(0.04, "a")});
  const auto notices = JudgeNotices(timeline, 0);
  ASSERT_THAT(notices, SizeIs(1));
  EXPECT_NEAR(notices[0].distance_m, 0.04, 1e-12);
  EXPECT_EQ(notices[0].moments, 1);  // at half of the distance
}

TEST(Notices, EventsThatNobodyCanSeeAreNotAsked) {
  TrueThing hidden = ThingAt(0);
  hidden.visible_share = 0.05;
  const auto timeline = TimelineOfOne().Then(5, Absent(), {}).Then(5, hidden, {});
  EXPECT_THAT(JudgeNotices(timeline, 0), IsEmpty());
}

TEST(Identity, CountsSwitchesAndReturnsApart) {
  const auto timeline = TimelineOfOne()
                            .Then(10, ThingAt(0), {ObjectAt(0, "a")})
                            .Then(10, ThingAt(0), {ObjectAt(0, "b")})
                            .Then(10, Absent(), {})
                            .Then(10, ThingAt(0), {ObjectAt(0, "b")})
                            .Then(10, Absent(), {})
                            .Then(10, ThingAt(0), {ObjectAt(0, "c")});
  const IdentityVerdict verdict = JudgeIdentity(timeline, 0);
  EXPECT_EQ(verdict.object_frames, 40);
  EXPECT_EQ(verdict.switches, 1);
  EXPECT_EQ(verdict.returns, 2);
  EXPECT_EQ(verdict.names_kept, 1);
}

TEST(Changes, AThingThatIsAddedLateIsTrueButNotASecondTime) {
  const auto timeline = TimelineOfOne()
                            .Then(5, Absent(), {})
                            .Then(30, ThingAt(0), {})
                            .Then(5, ThingAt(0), {ObjectAt(0, "a")})
                            .Then(20, ThingAt(0), {})
                            .Then(5, ThingAt(0), {ObjectAt(0, "a")});
  const ChangeVerdict verdict = JudgeChanges(timeline, 0);
  EXPECT_EQ(verdict.all.added, 2);
  EXPECT_EQ(verdict.unfounded.added, 1);
  EXPECT_EQ(verdict.unfounded.removed, 1);
}

TEST(Rests, CompareDisplacementsAndCountJitter) {
  const auto timeline = TimelineOfOne()
                            .Then(20, ThingAt(0), {ObjectAt(0.004, "a")})
                            .Then(20, ThingAt(0.05), {ObjectAt(0.055, "a")})
                            .Then(5, ThingAt(0.05), {ObjectAt(0.0551, "a")});
  const RestVerdict verdict = JudgeRests(timeline);
  ASSERT_THAT(verdict.errors_m, SizeIs(1));
  EXPECT_NEAR(verdict.errors_m[0], 0.001, 1e-12);
  EXPECT_EQ(verdict.jitter, 1);
  EXPECT_THAT(verdict.lines, ElementsAre(HasSubstr("as a, shifted at rest by 0.1 mm")));
}

TEST(Rests, ThatAreFarOffAreToldInWords) {
  const auto timeline = TimelineOfOne()
                            .Then(20, ThingAt(0), {ObjectAt(0, "a")})
                            .Then(20, ThingAt(0.02), {ObjectAt(0.017, "a")});
  EXPECT_THAT(JudgeRests(timeline).lines,
              ElementsAre(HasSubstr("thing 0, 100 % visible, as a, is not where it came to rest by "
                                    "3.0 mm")));
}

TEST(Rests, AreNotMeasuredBeforeTheyAreSettled) {
  const auto timeline = TimelineOfOne()
                            .Then(20, ThingAt(0), {ObjectAt(0, "a")})
                            .Then(8, ThingAt(0.05), {ObjectAt(0, "a")});
  EXPECT_THAT(JudgeRests(timeline).errors_m, IsEmpty());
}

}  // namespace
}  // namespace cwm::benchmarks
