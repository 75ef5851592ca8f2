#include "clients/cli/what_if.h"

#include <gtest/gtest.h>

#include "clients/cli/exit_code.h"

namespace cwm::cli {
namespace {

TEST(WhatIf, ReadsAsTheCommandsSay) {
  const auto move = ParseChange("move mug 1,2,3,0,0,0,1", "--what-if");
  ASSERT_TRUE(move.ok()) << move.status();
  EXPECT_EQ(move->move().name(), "mug");
  EXPECT_EQ(move->move().x_world_object().tz_m(), 3);
  EXPECT_EQ(ParseChange("  remove  mug ", "--what-if")->remove().name(), "mug");
  const auto attach = ParseChange("attach mug panda:panda_hand 0,0,0.1", "--what-if");
  ASSERT_TRUE(attach.ok()) << attach.status();
  EXPECT_EQ(attach->attach().robot(), "panda");
  EXPECT_EQ(attach->attach().link(), "panda_hand");
  EXPECT_EQ(attach->attach().x_link_object().tz_m(), 0.1);
  EXPECT_FALSE(
      ParseChange("attach mug panda:panda_hand", "--what-if")->attach().has_x_link_object());
  EXPECT_EQ(ParseChange("detach mug", "--what-if")->detach().name(), "mug");
  EXPECT_EQ(ParseChange("allow mug,panda:panda_hand", "--what-if")->allow().pair().b().link(),
            "panda_hand");
  const auto margin = ParseChange(
      R"({"margin": {"pair": {"a": {"name": "mug"}, "b": {"name": "*"}}, "margin_m": 0.02}})",
      "--what-if");
  ASSERT_TRUE(margin.ok()) << margin.status();
  EXPECT_EQ(margin->margin().margin_m(), 0.02);
}

TEST(WhatIf, AnythingElseIsAMistakeOfTheCommandLine) {
  for (const char* text :
       {"", "remove", "remove a b", "shove mug", "move mug", "move mug here", "move mug 1,2",
        "attach mug", "allow mug", "allow a,b,c", "{", R"({"shove": {}})"}) {
    const auto change = ParseChange(text, "--what-if");
    EXPECT_TRUE(IsUsageError(change.status())) << text << ": " << change.status();
    EXPECT_NE(change.status().message().find("--what-if"), std::string::npos)
        << text << ": " << change.status();
  }
}

}  // namespace
}  // namespace cwm::cli
