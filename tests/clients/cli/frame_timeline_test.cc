#include "clients/cli/frame_timeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "clients/cli/exit_code.h"

namespace cwm::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

formats::SequenceFrame Frame(const std::string& path, std::optional<double> stamp_s = {},
                             std::optional<double> delivery_s = {}) {
  return {.path = path, .source = path, .stamp_s = stamp_s, .delivery_s = delivery_s};
}

formats::SequenceState State(const std::string& robot, double stamp_s, double delivery_s,
                             std::vector<double> values = {1, 2}) {
  return {.robot = robot,
          .source = "joint_states.jsonl:1",
          .stamp_s = stamp_s,
          .delivery_s = delivery_s,
          .values = std::move(values)};
}

// "path@stamp due" of each frame; a frame without a stamp is "path".
std::vector<std::string> Frames(FrameSource& source) {
  std::vector<std::string> texts;
  while (true) {
    const auto frame = source.NextFrame();
    EXPECT_TRUE(frame.ok()) << frame.status();
    if (!frame.ok() || !frame->has_value()) return texts;
    std::ostringstream text;
    text << (*frame)->frame.path;
    if ((*frame)->stamp_s) text << "@" << *(*frame)->stamp_s << " " << (*frame)->due_s;
    texts.push_back(text.str());
  }
}

TEST(FrameTimeline, FramesWithoutStampsAreStampedByTheRate) {
  const auto source = MakeFolderSource({.frames = {Frame("a"), Frame("b"), Frame("c")}}, 4, 1);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->stamps()->end_s, 0.5);
  EXPECT_THAT(Frames(**source), ElementsAre("a@0 0", "b@0.25 0.25", "c@0.5 0.5"));
}

TEST(FrameTimeline, RoundsFollowEachOtherAtTheIntervalOfTheFrames) {
  const auto source = MakeFolderSource(
      {.frames = {Frame("a", 10, 10.5), Frame("b", 11, 11)}, .states = {State("arm", 10, 10.25)}},
      {}, 2);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->stamps()->begin_s, 10);
  EXPECT_EQ((*source)->stamps()->end_s, 13);
  EXPECT_THAT(Frames(**source), ElementsAre("a@10 10.5", "b@11 11", "a@12 12.5", "b@13 13"));
  EXPECT_EQ((*source)->NextState(10.2), std::nullopt);
  const auto first = (*source)->NextState(10.3);
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->stamp_s, 10);
  EXPECT_EQ((*source)->NextStateDue(), 12.25);
  EXPECT_EQ((*source)->NextState(20)->stamp_s, 12);
  EXPECT_EQ((*source)->NextStateDue(), std::nullopt);
}

TEST(FrameTimeline, RobotsAreThoseOfTheStates) {
  const auto source =
      MakeFolderSource({.frames = {Frame("a", 1)},
                        .states = {State("b", 1, 1), State("a", 1, 1, {3}), State("b", 2, 2)}},
                       {}, 1);
  ASSERT_TRUE(source.ok()) << source.status();
  const auto robots = (*source)->robots();
  ASSERT_EQ(robots.size(), 2u);
  EXPECT_EQ(robots[0]->robot, "a");
  EXPECT_THAT(robots[0]->values, ElementsAre(3));
}

TEST(FrameTimeline, RefusesWhatHasNoOneMeaning) {
  const auto rate = MakeFolderSource({.frames = {Frame("a", 1)}}, 30, 1);
  EXPECT_TRUE(IsUsageError(rate.status())) << rate.status();
  const auto mixed = MakeFolderSource({.frames = {Frame("a", 1), Frame("b")}}, {}, 1);
  EXPECT_THAT(std::string(mixed.status().message()), HasSubstr("b: stamp is missing"));
  const auto states = MakeFolderSource(
      {.frames = {Frame("a", 1)}, .states = {State("arm", 1, 1), State("arm", 2, 2, {1})}}, {}, 1);
  EXPECT_THAT(std::string(states.status().message()), HasSubstr("must be the same in all states"));
}

TEST(FrameTimeline, ListsAreReadLineByLine) {
  std::istringstream lines("a.png\n\nb.png\n");
  const auto source = MakeListSource(lines, "-", {});
  EXPECT_EQ(source->stamps().has_value(), false);
  EXPECT_THAT(Frames(*source), ElementsAre("a.png", "b.png"));
  std::istringstream stamped("a.png 5\n{\"file\": \"b.png\", \"stamp\": 6, \"delivery\": 6.5}\n");
  EXPECT_THAT(Frames(*MakeListSource(stamped, "-", {})), ElementsAre("a.png@5 5", "b.png@6 6.5"));
  std::istringstream timed("a.png\nb.png\n");
  EXPECT_THAT(Frames(*MakeListSource(timed, "-", 2)), ElementsAre("a.png@0 0", "b.png@0.5 0.5"));
}

TEST(FrameTimeline, LinesOfAListAreNamedByTheirNumbers) {
  std::istringstream lines("a.png 5\n\nb.png\n");
  const auto source = MakeListSource(lines, "-", {});
  ASSERT_TRUE(source->NextFrame().ok());
  EXPECT_THAT(std::string(source->NextFrame().status().message()),
              HasSubstr("-:3: the frame has no stamp"));
  std::istringstream malformed("a.png later\n");
  EXPECT_THAT(std::string(MakeListSource(malformed, "-", {})->NextFrame().status().message()),
              HasSubstr("-:1: the stamp is later"));
  std::istringstream twice("a.png 5\n");
  EXPECT_TRUE(IsUsageError(MakeListSource(twice, "-", 30)->NextFrame().status()));
}

}  // namespace
}  // namespace cwm::cli
