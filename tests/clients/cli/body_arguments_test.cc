#include "clients/cli/body_arguments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace cwm::cli {
namespace {

using ::testing::HasSubstr;

absl::StatusOr<std::vector<cwm::v1::Subject>> Read(const BodyArguments& body,
                                                   const std::string& in) {
  std::istringstream input(in);
  std::ostringstream out, err;
  Session session({.in = input, .out = out, .err = err});
  return ReadSubjects(body, session);
}

TEST(ReadSubjects, TakesAShapeAtSeveralPoses) {
  BodyArguments body;
  body.shape.cone = "0.05,0.03,0.1";
  body.at = {"1,2,3", "4,5,6,0,0,0,1"};
  const auto subjects = Read(body, "");
  ASSERT_TRUE(subjects.ok()) << subjects.status();
  ASSERT_EQ(subjects->size(), 1u);
  EXPECT_EQ(RowCount(subjects->front()), 2u);
  const auto& cone = subjects->front().shapes().shapes(0).cone();
  EXPECT_EQ(cone.radius_bottom_m(), 0.05);
  EXPECT_EQ(cone.radius_top_m(), 0.03);
  EXPECT_EQ(cone.length_m(), 0.1);
}

TEST(ReadSubjects, AsksForAnObjectWhereItStands) {
  BodyArguments body;
  body.object = "cup";
  const auto subjects = Read(body, "");
  ASSERT_TRUE(subjects.ok()) << subjects.status();
  EXPECT_EQ(subjects->front().object().name(), "cup");
  EXPECT_EQ(subjects->front().object().x_world_object().data(), "");
  EXPECT_EQ(RowCount(subjects->front()), 1u);
}

TEST(ReadSubjects, JoinsLinesOfTheSameBodyAndKeepsTheirOrder) {
  const auto subjects = Read({},
                             "{\"sphere\": 0.1, \"at\": [0, 0, 0]}\n\n"
                             "{\"sphere\": [0.1], \"at\": [[1, 0, 0], [2, 0, 0, 0, 0, 0, 1]]}\n"
                             "{\"object\": \"cup\"}\n"
                             "{\"sphere\": 0.1, \"at\": [3, 0, 0]}\n");
  ASSERT_TRUE(subjects.ok()) << subjects.status();
  ASSERT_EQ(subjects->size(), 3u);
  EXPECT_EQ(RowCount((*subjects)[0]), 3u);
  EXPECT_TRUE((*subjects)[1].has_object());
  EXPECT_EQ(RowCount((*subjects)[2]), 1u);
}

TEST(ReadSubjects, SplitsLongListsAtTheServersLimit) {
  BodyArguments body;
  body.shape.sphere = "0.1";
  body.at = {"-"};
  std::string lines;
  for (std::size_t i = 0; i < 2 * kMaxRows + 1; ++i) lines += "[0, 0, 1]\n";
  const auto subjects = Read(body, lines);
  ASSERT_TRUE(subjects.ok()) << subjects.status();
  ASSERT_EQ(subjects->size(), 3u);
  EXPECT_EQ(RowCount((*subjects)[1]), kMaxRows);
  EXPECT_EQ(RowCount((*subjects)[2]), 1u);
}

TEST(ReadSubjects, RefusesLinesThatSayTooMuchOrTooLittle) {
  const std::pair<const char*, const char*> lines[] = {
      {"nonsense", "must be a JSON object"},
      {"{\"at\": [0, 0, 0]}", "must name one shape or an object"},
      {"{\"sphere\": 1, \"box\": [1, 1, 1], \"at\": [0, 0, 0]}", "only one shape"},
      {"{\"sphere\": 1, \"object\": \"cup\", \"at\": [0, 0, 0]}", "one shape or an object"},
      {"{\"sphere\": \"big\", \"at\": [0, 0, 0]}", "must hold numbers alone"},
      {"{\"box\": [1, 2], \"at\": [0, 0, 0]}", "has 2 numbers"},
      {"{\"sphere\": 1, \"at\": [0, 0]}", "has 2 numbers"},
      {"{\"sphere\": 1, \"at\": []}", "has 0 numbers"},
      {"{\"torus\": 1, \"at\": [0, 0, 0]}", "\"torus\" is unknown"},
      {"", "holds no question"},
  };
  for (const auto& [line, rule] : lines) {
    const auto subjects = Read({}, line);
    EXPECT_EQ(subjects.status().code(), absl::StatusCode::kInvalidArgument) << line;
    EXPECT_THAT(std::string(subjects.status().message()), HasSubstr(rule)) << line;
  }
}

}  // namespace
}  // namespace cwm::cli
