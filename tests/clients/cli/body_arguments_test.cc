#include "clients/cli/body_arguments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <sstream>

namespace cwm::cli {
namespace {

using ::testing::HasSubstr;

absl::StatusOr<std::vector<Batch>> Read(const BodyArguments& body, const std::string& in) {
  std::istringstream input(in);
  std::ostringstream out, err;
  Session session({.in = input, .out = out, .err = err});
  return ReadBatches(body, session);
}

TEST(ReadBatches, TakesAShapeAtSeveralPoses) {
  BodyArguments body;
  body.shape.cone = "0.05,0.03,0.1";
  body.at = {"1,2,3", "4,5,6,0,0,0,1"};
  const auto batches = Read(body, "");
  ASSERT_TRUE(batches.ok()) << batches.status();
  ASSERT_EQ(batches->size(), 1u);
  EXPECT_EQ(batches->front().row_count, 2u);
  const auto& cone = batches->front().subject.shapes().shapes(0).cone();
  EXPECT_EQ(cone.radius_bottom_m(), 0.05);
  EXPECT_EQ(cone.radius_top_m(), 0.03);
  EXPECT_EQ(cone.length_m(), 0.1);
}

TEST(ReadBatches, PutsTheRootLinkOfARobotWhereAtSays) {
  BodyArguments body;
  body.robot.name = "panda";
  body.at = {"1,2,3"};
  const auto batches = Read(body, "");
  ASSERT_TRUE(batches.ok()) << batches.status();
  EXPECT_EQ(batches->front().subject.robot().x_world_base().ty_m(), 2);
  body.at = {"1,2,3", "1,2,4"};
  EXPECT_THAT(std::string(Read(body, "").status().message()),
              HasSubstr("--at: of a robot one pose"));
  body.at = {"-"};
  EXPECT_THAT(std::string(Read(body, "").status().message()),
              HasSubstr("--at: of a robot one pose"));
}

TEST(ReadBatches, AsksForAnObjectWhereItStands) {
  BodyArguments body;
  body.object = "cup";
  const auto batches = Read(body, "");
  ASSERT_TRUE(batches.ok()) << batches.status();
  EXPECT_EQ(batches->front().subject.object().name(), "cup");
  EXPECT_EQ(batches->front().subject.object().x_world_object().data(), "");
  EXPECT_EQ(batches->front().row_count, 1u);
}

TEST(ReadBatches, JoinsLinesOfTheSameBodyAndKeepsTheirOrder) {
  const auto batches = Read({},
                            "{\"sphere\": 0.1, \"at\": [0, 0, 0]}\n\n"
                            "{\"sphere\": [0.1], \"at\": [[1, 0, 0], [2, 0, 0, 0, 0, 0, 1]]}\n"
                            "{\"object\": \"cup\"}\n"
                            "{\"sphere\": 0.1, \"at\": [3, 0, 0]}\n");
  ASSERT_TRUE(batches.ok()) << batches.status();
  ASSERT_EQ(batches->size(), 3u);
  EXPECT_EQ((*batches)[0].row_count, 3u);
  EXPECT_TRUE((*batches)[1].subject.has_object());
  EXPECT_EQ((*batches)[2].row_count, 1u);
}

TEST(ReadBatches, SplitsLongListsAtTheServersLimit) {
  BodyArguments body;
  body.shape.sphere = "0.1";
  body.at = {"-"};
  std::string lines;
  for (std::size_t i = 0; i < 2 * kMaxRows + 1; ++i) lines += "[0, 0, 1]\n";
  const auto batches = Read(body, lines);
  ASSERT_TRUE(batches.ok()) << batches.status();
  ASSERT_EQ(batches->size(), 3u);
  EXPECT_EQ((*batches)[1].row_count, kMaxRows);
  EXPECT_EQ((*batches)[2].row_count, 1u);
}

TEST(ReadBatches, RefusesLinesThatSayTooMuchOrTooLittle) {
  const std::pair<const char*, const char*> lines[] = {
      {"nonsense", "must be a JSON object"},
      {"{\"at\": [0, 0, 0]}", "must name one shape or an object or a robot"},
      {"{\"sphere\": 1, \"box\": [1, 1, 1], \"at\": [0, 0, 0]}", "only one shape"},
      {"{\"sphere\": 1, \"object\": \"cup\", \"at\": [0, 0, 0]}",
       "one shape or an object or a robot"},
      {"{\"sphere\": \"big\", \"at\": [0, 0, 0]}", "must hold numbers alone"},
      {"{\"box\": [1, 2], \"at\": [0, 0, 0]}", "has 2 numbers"},
      {"{\"sphere\": 1, \"at\": [0, 0]}", "has 2 numbers"},
      {"{\"sphere\": 1, \"at\": []}", "has 0 numbers"},
      {"{\"torus\": 1, \"at\": [0, 0, 0]}", "\"torus\" is unknown"},
      {"", "holds no question"},
  };
  for (const auto& [line, rule] : lines) {
    const auto batches = Read({}, line);
    EXPECT_EQ(batches.status().code(), absl::StatusCode::kInvalidArgument) << line;
    EXPECT_THAT(std::string(batches.status().message()), HasSubstr(rule)) << line;
  }
}

std::vector<double> NumbersIn(const std::string& bytes) {
  std::vector<double> values(bytes.size() / sizeof(double));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

TEST(ReadBatches, TakesARobotInStates) {
  BodyArguments body;
  body.robot = {.name = "arm",
                .group = "reach",
                .joints = {"0.1,-0.2", "3,4"},
                .at = "1,2,3",
                .scope = cwm::v1::ROBOT_SCOPE_SELF,
                .geometry = cwm::v1::ROBOT_GEOMETRY_SPHERES_AS_GIVEN};
  const auto batches = Read(body, "");
  ASSERT_TRUE(batches.ok()) << batches.status();
  ASSERT_EQ(batches->size(), 1u);
  EXPECT_EQ(batches->front().row_count, 2u);
  const cwm::v1::RobotSubject& robot = batches->front().subject.robot();
  EXPECT_EQ(robot.robot(), "arm");
  EXPECT_EQ(robot.group(), "reach");
  EXPECT_EQ(robot.x_world_base().tz_m(), 3);
  EXPECT_EQ(robot.scope(), cwm::v1::ROBOT_SCOPE_SELF);
  EXPECT_EQ(robot.robot_geometry(), cwm::v1::ROBOT_GEOMETRY_SPHERES_AS_GIVEN);
  EXPECT_THAT(NumbersIn(robot.rows().data()), ::testing::ElementsAre(0.1, -0.2, 3, 4));
}

TEST(ReadBatches, AsksForARobotAsItStands) {
  BodyArguments body;
  body.robot.name = "arm";
  const auto batches = Read(body, "");
  ASSERT_TRUE(batches.ok()) << batches.status();
  EXPECT_EQ(batches->front().row_count, 1u);
  EXPECT_EQ(batches->front().subject.robot().rows().data(), "");
}

TEST(ReadBatches, TakesRobotsFromLines) {
  const auto batches =
      Read({},
           "{\"robot\": \"arm\", \"group\": \"reach\", \"joints\": [1, 2]}\n"
           "{\"robot\": \"arm\", \"group\": \"reach\", \"joints\": [[3, 4], [5, 6]]}\n"
           "{\"robot\": \"arm\", \"joints\": [7, 8, 9]}\n");
  ASSERT_TRUE(batches.ok()) << batches.status();
  ASSERT_EQ(batches->size(), 2u);
  EXPECT_EQ((*batches)[0].row_count, 3u);
  EXPECT_EQ((*batches)[1].row_count, 1u);
  BodyArguments given;
  given.robot.name = "arm";
  given.robot.joints = {"-"};
  const auto alone = Read(given, "[1, 2]\n{\"joints\": [3, 4]}\n");
  ASSERT_TRUE(alone.ok()) << alone.status();
  EXPECT_THAT(NumbersIn(alone->front().subject.robot().rows().data()),
              ::testing::ElementsAre(1, 2, 3, 4));
}

TEST(ReadBodies, KeepTogetherWhatALineHas) {
  std::istringstream input("[[0, 0, 0], [1, 0, 0], [2, 0, 0]]\n{\"at\": [[3, 0, 0], [4, 0, 0]]}\n");
  std::ostringstream out, err;
  Session session({.in = input, .out = out, .err = err});
  BodyArguments body;
  body.shape.sphere = "0.1";
  body.at = {"-"};
  const auto bodies = ReadBodies(body, session);
  ASSERT_TRUE(bodies.ok()) << bodies.status();
  ASSERT_EQ(bodies->size(), 1u);
  EXPECT_THAT(bodies->front().row_counts, ::testing::ElementsAre(3, 2));
  EXPECT_EQ(bodies->front().row_count(), 5u);
}

TEST(ReadBatches, RefusesRobotsThatSayTooMuchOrTooLittle) {
  const std::pair<const char*, const char*> lines[] = {
      {"{\"robot\": \"a\", \"at\": [0, 0, 0]}", "\"at\" must be \"joints\""},
      {"{\"object\": \"a\", \"joints\": [0, 0, 0]}", "\"joints\" must be \"at\""},
      {"{\"object\": \"a\", \"group\": \"b\"}", "\"group\" is one of a robot"},
      {"{\"robot\": \"a\", \"object\": \"b\"}", "must name one shape or an object or a robot"},
      {"{\"robot\": \"a\", \"joints\": [[1, 2], [3]]}", "has 1 numbers, must have 2 as the row"},
      {"{\"robot\": \"a\", \"joints\": [\"b\"]}", "must hold numbers alone"},
      {"{\"robot\": \"a\", \"joints\": []}", "must have one for each joint"},
  };
  for (const auto& [line, rule] : lines) {
    const auto batches = Read({}, line);
    EXPECT_EQ(batches.status().code(), absl::StatusCode::kInvalidArgument) << line;
    EXPECT_THAT(std::string(batches.status().message()), HasSubstr(rule)) << line;
  }
  BodyArguments body;
  body.robot.group = "reach";
  EXPECT_THAT(std::string(Read(body, "").status().message()), HasSubstr("--robot is missing"));
  body.robot.name = "arm";
  body.object = "cup";
  EXPECT_THAT(std::string(Read(body, "").status().message()), HasSubstr("not together with"));
  body.object.clear();
  body.robot.joints = {"1,2", "1"};
  EXPECT_THAT(std::string(Read(body, "").status().message()), HasSubstr("has 1 numbers"));
}

}  // namespace
}  // namespace cwm::cli
