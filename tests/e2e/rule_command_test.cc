// `cwm allow`, `cwm margin`, `cwm rules` and queries under them, as a user types them.
#include <gmock/gmock.h>

#include <chrono>
#include <thread>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

// A box of 0.2 m at the origin; the query's ball is 0.05 m beside it.
class RuleCommand : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    ASSERT_EQ(Cwm({"put", "crate", "--box", "0.2,0.2,0.2", "--at", "0,0,0"}).exit_code, 0);
  }
  // True if the ball at `at` collides under the options `more`.
  bool Collides(std::vector<std::string> more = {}, const std::string& at = "0.25,0,0") {
    std::vector<std::string> line = {"check", "--sphere", "0.1", "--at", at, "--exit-code"};
    line.insert(line.end(), more.begin(), more.end());
    const ProcessResult checked = Cwm(line);
    EXPECT_TRUE(checked.exit_code == 0 || checked.exit_code == 10) << checked.err;
    return checked.exit_code == 10;
  }
};

TEST_F(RuleCommand, SetsListsAndEndsRules) {
  EXPECT_FALSE(Collides());
  EXPECT_EQ(CwmJson({"margin", "crate", "*", "0.06"}).at("revision"), "2");
  EXPECT_TRUE(Collides());
  EXPECT_EQ(CwmJson({"allow", "crate", "*"}).at("revision"), "3");
  EXPECT_FALSE(Collides());
  EXPECT_FALSE(Collides({}, "0,0,0"));
  const json rules = CwmJson({"rules"}).at("pair_rules");
  ASSERT_EQ(rules.size(), 1u);
  EXPECT_EQ(rules[0].at("pair").at("a").at("name"), "*");
  EXPECT_EQ(rules[0].at("allowed"), true);
  EXPECT_EQ(rules[0].at("margin_m"), 0.06);
  const std::string table = Cwm({"rules"}).out;
  EXPECT_THAT(table, HasSubstr("allowed, margin 60.0 mm"));
  EXPECT_THAT(Cwm({"allow", "crate", "*", "--withdraw"}).out, HasSubstr("withdrawn"));
  EXPECT_EQ(CwmJson({"margin", "*", "crate", "--unset"}).at("revision"), "5");
  EXPECT_THAT(Cwm({"rules"}).out, HasSubstr("no rules of pairs"));
  EXPECT_EQ(Cwm({"allow", "panda:panda_hand", "not/there-yet.1"}).exit_code, 0);
  EXPECT_THAT(Cwm({"rules"}).out, HasSubstr("panda:panda_hand"));
}

TEST_F(RuleCommand, WarnsOfNamesThatNothingHas) {
  const std::vector<std::string> ball = {"check", "--sphere", "0.1", "--at", "0,0,0"};
  const auto warned = [&](std::vector<std::string> line, const std::vector<std::string>& more) {
    line.insert(line.end(), more.begin(), more.end());
    const ProcessResult finished = Cwm(line);
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    return finished.err;
  };
  EXPECT_THAT(warned(ball, {"--ignore", "crat"}),
              HasSubstr("--ignore: nothing is named \"crat\"; did you mean crate?"));
  EXPECT_THAT(warned(ball, {"--ignore", "spoon"}), HasSubstr("nothing is named \"spoon\"\n"));
  EXPECT_EQ(warned(ball, {"--ignore", "crate"}), "");
  EXPECT_THAT(warned(ball, {"--ignore-pair", "crat,*"}), HasSubstr("did you mean crate?"));
  EXPECT_EQ(warned(ball, {"--ignore-pair", "crate,*"}), "");
  for (const std::vector<std::string>& query :
       {std::vector<std::string>{"ray", "--from", "0,0,1", "--direction", "0,0,-1"},
        {"sample", "0,0,1"},
        {"distance", "--sphere", "0.1", "--at", "0,0,1"},
        {"motion", "--sphere", "0.1", "--at", "0,0,1", "--at", "0,0,2"}}) {
    EXPECT_THAT(warned(query, {"--ignore", "crat"}), HasSubstr("did you mean crate?"));
  }
  EXPECT_THAT(warned({"allow", "crat", "*"}, {}), HasSubstr("did you mean crate?"));
  EXPECT_THAT(warned({"margin", "crate", "crat", "0.1"}, {}), HasSubstr("did you mean crate?"));
  EXPECT_EQ(warned({"allow", "spoon", "crate"}, {}), "") << "it may come later";
  const ProcessResult world = Cwm({"objects", "--world", "defalt"});
  EXPECT_EQ(world.exit_code, 3);
  EXPECT_THAT(world.err, HasSubstr("did you mean default?"));
}

TEST_F(RuleCommand, AllowsForAWhile) {
  EXPECT_EQ(CwmJson({"allow", "crate", "*", "--for", "0.3"}).at("revision"), "2");
  EXPECT_THAT(Cwm({"rules"}).out, ::testing::AnyOf(HasSubstr("allowed until"), HasSubstr("no ")));
  // The watch ends with the message of the expiry, the second one after revision 1.
  const ProcessResult watched = Cwm({"--deadline", "20", "watch", "--from", "1", "--world-uid",
                                     UidOf("default"), "--count", "2"});
  EXPECT_THAT(watched.out, HasSubstr("2  rule    * and crate  allowed until"));
  EXPECT_THAT(watched.out, HasSubstr("3  rule    * and crate  no rule"));
  EXPECT_TRUE(Collides({}, "0,0,0"));
}

TEST_F(RuleCommand, QuestionsHaveRulesOfTheirOwn) {
  EXPECT_TRUE(Collides({}, "0,0,0"));
  EXPECT_FALSE(Collides({"--ignore-pair", "*,crate"}, "0,0,0"));
  EXPECT_FALSE(Collides({"--margin-sigma", "3"}));  // a user's object has no fit uncertainty
  const json distances = CwmJson({"distance", "--sphere", "0.1", "--at", "1,0,0", "--ignore-pair",
                                  "crate,*", "--margin-sigma", "2"});
  EXPECT_EQ(distances.at("objects").size(), 0u);
  const json touched =
      CwmJson({"contacts", "--sphere", "0.1", "--at", "0,0,0", "--ignore-pair", "crate,*"});
  EXPECT_EQ(touched.at("objects").size(), 0u);
}

TEST_F(RuleCommand, QuestionsSayWhatUnseenSpaceCountsAs) {
  ASSERT_EQ(Cwm({"put", "shadow", "--box", "1,1,1", "--at", "2,0,0", "--unseen"}).exit_code, 0);
  const auto verdict = [&](const std::string& unseen) {
    return CwmJson({"check", "--sphere", "0.1", "--at", "2,0,0", "--unseen", unseen})
        .at("rows")[0]
        .at("verdict");
  };
  EXPECT_EQ(verdict("block"), "VERDICT_COLLISION");
  EXPECT_EQ(verdict("report"), "VERDICT_UNDECIDED");
  EXPECT_EQ(verdict("ignore"), "VERDICT_FREE");
}

TEST_F(RuleCommand, SaysWhatIsWrong) {
  const auto failure = [&](std::vector<std::string> line, int exit_code, const std::string& text) {
    const ProcessResult finished = Cwm(std::move(line));
    EXPECT_EQ(finished.exit_code, exit_code) << finished.err;
    EXPECT_THAT(finished.err, HasSubstr(text));
  };
  failure({"allow", "crate", "a cup"}, 8, "allow.pair.b.name");
  failure({"allow", "*:hand", "crate"}, 1, "ROBOT:LINK");
  failure({"allow", "panda:", "crate"}, 1, "ROBOT:LINK");
  failure({"allow", "crate", "cup", "--for", "0"}, 1, "--for: is 0");
  failure({"allow", "crate", "cup", "--for", "nan"}, 1, "--for");
  failure({"allow", "crate", "cup", "--for", "1", "--withdraw"}, 1, "--withdraw");
  failure({"margin", "crate", "cup"}, 1, "--unset");
  failure({"margin", "crate", "cup", "nan"}, 8, "margin.margin_m");
  failure({"check", "--sphere", "0.1", "--at", "0,0,0", "--ignore-pair", "crate"}, 1, "A,B");
  failure({"check", "--sphere", "0.1", "--at", "0,0,0", "--margin-sigma", "nan"}, 8,
          "options.margin_sigma");
}

}  // namespace
}  // namespace cwm::testing
