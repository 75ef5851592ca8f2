#include "clients/cli/number_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "clients/cli/exit_code.h"

namespace cwm::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(NumberList, ReadsNumbersAndPoses) {
  EXPECT_THAT(*ParseNumbers("-0.5,1e-3,2", {"--box", "X,Y,Z", 3}), ElementsAre(-0.5, 1e-3, 2));
  EXPECT_THAT(*ParsePose("1,2,3", "--at"), ElementsAre(1, 2, 3, 0, 0, 0, 1));
  EXPECT_THAT(*ParsePose("1,2,3,0,0,1,0", "--at"), ElementsAre(1, 2, 3, 0, 0, 1, 0));
}

TEST(NumberList, NamesOptionTextAndForm) {
  for (const char* text : {"", "1,2", "1,2,3,4", "1,,3", "1,2,x", "a,b,c", "1 2 3"}) {
    const auto numbers = ParseNumbers(text, {"--box", "X,Y,Z", 3});
    EXPECT_TRUE(IsUsageError(numbers.status())) << text;
    EXPECT_THAT(std::string(numbers.status().message()), HasSubstr("--box: \""));
    EXPECT_THAT(std::string(numbers.status().message()), HasSubstr("must be X,Y,Z"));
  }
  EXPECT_TRUE(IsUsageError(ParsePose("1,2,3,4", "--at").status()));
}

}  // namespace
}  // namespace cwm::cli
