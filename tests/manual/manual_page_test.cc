#include "manual/manual_page.h"

#include <gmock/gmock.h>

#include <sstream>

namespace cwm::manual {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr char kDescription[] =
    "teapot: makes tea\n\n"
    "Examples:\n"
    "  teapot pour --cups 2\n\n"
    "Never coffee.\n\n"
    "Exit codes: 0 done, 1 usage,\n"
    "2 empty.";

class ManualPageTest : public ::testing::Test {
 protected:
  ManualPageTest() {
    pour_ = app_.add_subcommand("pour", "fills cups\n\nExamples:\n  teapot pour");
    pour_->add_option("--cups", cups_, "how many")->type_name("N");
    app_.add_subcommand("__inner", "not for people")->group("");
  }
  std::string Page() const { return ManualPage(app_, {.version = "1.2.3"}); }

  CLI::App app_{kDescription, "teapot"};
  CLI::App* pour_;
  int cups_ = 0;
};

TEST_F(ManualPageTest, StartsWithNameAndSummary) {
  EXPECT_THAT(Page(), StartsWith(".TH TEAPOT 1 \"\" \"cwm 1.2.3\"\n"
                                 ".SH NAME\nteapot \\- makes tea\n"
                                 ".SH SYNOPSIS\n\\fBteapot\\fR [\\fIOPTIONS\\fR] "
                                 "\\fICOMMAND\\fR ...\n"));
}

TEST_F(ManualPageTest, GivesEachParagraphItsSection) {
  EXPECT_THAT(Page(), HasSubstr(".SH DESCRIPTION\nNever coffee.\n"));
  EXPECT_THAT(Page(), HasSubstr(".SH EXIT STATUS\n0 done, 1 usage,\n2 empty.\n"));
  EXPECT_THAT(Page(), HasSubstr(".SH EXAMPLES\n.nf\nteapot pour \\-\\-cups 2\n.fi\n"));
}

TEST_F(ManualPageTest, TellsOfCommandsAndTheirOptions) {
  EXPECT_THAT(Page(), HasSubstr(".SS pour\nfills cups\n"));
  EXPECT_THAT(Page(), HasSubstr(".TP\n\\fB\\-\\-cups\\fR \\fIN\\fR\nhow many\n"));
}

TEST_F(ManualPageTest, HidesWhatHelpHides) { EXPECT_THAT(Page(), Not(HasSubstr("inner"))); }

TEST_F(ManualPageTest, LeavesOutSectionsWithoutContent) {
  EXPECT_THAT(Page(), Not(HasSubstr("ENVIRONMENT")));
  EXPECT_THAT(
      ManualPage(app_, {.version = "1.2.3", .environment = {{"TEA_KIND", "green or black"}}}),
      HasSubstr(".SH ENVIRONMENT\n.TP\n\\fBTEA_KIND\\fR\ngreen or black\n"));
}

TEST_F(ManualPageTest, ShowsWhatRoffWouldTakeForItsOwn) {
  pour_->add_option("--path", cups_, ".hidden or C:\\tea\n'quoted'");
  EXPECT_THAT(Page(), HasSubstr("\n\\&.hidden or C:\\etea\n\\&'quoted'\n"));
}

TEST_F(ManualPageTest, IsPrintedByAnOptionThatNoHelpShows) {
  AddManualPage(app_, {.version = "1.2.3"});
  app_.require_subcommand(1);  // as a version, it is answered without one
  EXPECT_THAT(app_.help(), Not(HasSubstr("manual-page")));
  std::ostringstream out, err;
  try {
    app_.parse("--manual-page");
    FAIL() << "nothing was asked for";
  } catch (const CLI::ParseError& error) {
    EXPECT_EQ(app_.exit(error, out, err), 0);
  }
  EXPECT_EQ(out.str(), Page() + "\n");
  EXPECT_EQ(err.str(), "");
}

}  // namespace
}  // namespace cwm::manual
