#include "clients/cli/link_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "clients/cli/exit_code.h"

namespace cwm::cli {
namespace {

using ::testing::HasSubstr;

TEST(LinkValues, EndWithTheNumberAfterTheLastSign) {
  const auto padding = ParseLinkPadding("odd=name=0.02");
  ASSERT_TRUE(padding.ok()) << padding.status();
  EXPECT_EQ(padding->link(), "odd=name");
  EXPECT_EQ(padding->padding_m(), 0.02);
  const auto scale = ParseLinkScale("*=1.1");
  ASSERT_TRUE(scale.ok()) << scale.status();
  EXPECT_EQ(scale->link(), "*");
  EXPECT_EQ(scale->scale(), 1.1);
  for (const char* text : {"", "hand", "=0.1", "hand=", "hand=far", "hand=1,2"}) {
    const absl::Status status = ParseLinkPadding(text).status();
    EXPECT_TRUE(IsUsageError(status)) << text;
    EXPECT_THAT(std::string(status.message()), HasSubstr("must be LINK=METRES")) << text;
  }
}

TEST(LinkValues, ToolsHaveALinkAndPerhapsAPose) {
  const auto bare = ParseTool("tip=hand");
  ASSERT_TRUE(bare.ok()) << bare.status();
  EXPECT_EQ(bare->name(), "tip");
  EXPECT_EQ(bare->link(), "hand");
  EXPECT_FALSE(bare->has_x_link_tool());
  const auto posed = ParseTool("tip=left@hand@0,0,0.1,1,0,0,0");
  ASSERT_TRUE(posed.ok()) << posed.status();
  EXPECT_EQ(posed->link(), "left@hand") << "the last sign begins the pose";
  EXPECT_EQ(posed->x_link_tool().tz_m(), 0.1);
  EXPECT_EQ(posed->x_link_tool().qx(), 1);
  for (const char* text : {"", "tip", "=hand", "tip=", "tip@0,0,1", "tip=hand@0,0"}) {
    EXPECT_TRUE(IsUsageError(ParseTool(text).status())) << text;
  }
}

TEST(LinkValues, GroupsOfToolsAreNamed) {
  const auto named = ParseToolGroup("tip=panda_arm");
  ASSERT_TRUE(named.ok()) << named.status();
  EXPECT_EQ(named->first, "tip");
  EXPECT_EQ(named->second, "panda_arm");
  for (const char* text : {"", "tip", "tip=", "=arm"}) {
    EXPECT_TRUE(IsUsageError(ParseToolGroup(text).status())) << text;
  }
}

}  // namespace
}  // namespace cwm::cli
