#include "clients/cli/pair_arguments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "clients/cli/exit_code.h"

namespace cwm::cli {
namespace {

using ::testing::HasSubstr;

TEST(PairArguments, AMemberIsANameALinkOrEverything) {
  for (const char* text : {"cup", "a/b.c-d_1", "panda:panda_hand", "panda:hand:left,1", "*"}) {
    const auto member = ParsePairMember(text, "A");
    ASSERT_TRUE(member.ok()) << member.status();
    EXPECT_EQ(PairMemberText(*member), text);
  }
  EXPECT_EQ(ParsePairMember("panda:hand:left", "A")->name(), "panda");
  EXPECT_EQ(ParsePairMember("panda:hand:left", "A")->link(), "hand:left");
  for (const char* text : {"", ":", ":hand", "panda:", "*:hand"}) {
    const auto status = ParsePairMember(text, "--a").status();
    EXPECT_TRUE(IsUsageError(status)) << text;
    EXPECT_THAT(std::string(status.message()),
                HasSubstr("--a: \"" + std::string(text) + "\" must"));
  }
}

TEST(PairArguments, APairHasOneComma) {
  const auto pair = ParsePair("panda:hand,*", "--ignore-pair");
  ASSERT_TRUE(pair.ok()) << pair.status();
  EXPECT_EQ(PairMemberText(pair->a()), "panda:hand");
  EXPECT_EQ(PairMemberText(pair->b()), "*");
  for (const char* text : {"", "cup", "a,b,c", ",cup", "cup,"}) {
    EXPECT_TRUE(IsUsageError(ParsePair(text, "--ignore-pair").status())) << text;
  }
}

TEST(PairArguments, ARuleReadsAsASentence) {
  cwm::v1::PairRule rule;
  EXPECT_EQ(FormatRule(rule), "no rule");
  rule.set_margin_m(0.02);
  EXPECT_EQ(FormatRule(rule), "margin 20.0 mm");
  rule.set_allowed(true);
  EXPECT_EQ(FormatRule(rule), "allowed, margin 20.0 mm");
  rule.clear_margin_m();
  rule.mutable_expires()->set_seconds(1'000'000'000);
  EXPECT_EQ(FormatRule(rule), "allowed until 2001-09-09 01:46:40 UTC");
  rule.Clear();
  rule.set_check(true);
  EXPECT_EQ(FormatRule(rule), "checked");
  rule.set_margin_m(0.02);
  EXPECT_EQ(FormatRule(rule), "checked, margin 20.0 mm");
}

}  // namespace
}  // namespace cwm::cli
