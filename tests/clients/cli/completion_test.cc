// Completion of a command line as the shells' scripts request it, and suggestions for typing
// errors.
#include "clients/cli/completion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "clients/cli/nearest_word.h"
#include "clients/cli/run.h"

namespace cwm::cli {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

struct Printed {
  ExitCode code;
  std::string out, err;
};

Printed RunWords(const std::vector<std::string>& arguments) {
  std::istringstream input;
  std::ostringstream out, err;
  const ExitCode code = Run(arguments, {.in = input, .out = out, .err = err});
  return {code, out.str(), err.str()};
}

// The words that may follow, one per line.
std::string After(std::vector<std::string> words) {
  words.insert(words.begin(), "__complete");
  const Printed printed = RunWords(words);
  EXPECT_EQ(printed.code, ExitCode::kDone);
  std::istringstream lines(printed.out);
  std::string all;
  for (std::string line; std::getline(lines, line);) all += line.substr(0, line.find('\t')) + "\n";
  return all;
}

TEST(Completion, OffersCommands) {
  EXPECT_EQ(After({"obj"}), "objects\n");
  EXPECT_THAT(After({""}), AllOf(HasSubstr("ingest\n"), Not(HasSubstr("__complete"))));
  EXPECT_EQ(After({"robot", "l"}), "load\nlist\n");
  EXPECT_EQ(After({"nothing", ""}), After({""})) << "a word that is no command changes nothing";
}

TEST(Completion, OffersOptionsOfTheCommandAndOfAll) {
  EXPECT_EQ(After({"distance", "--eng"}), "--engine\n");
  EXPECT_EQ(After({"distance", "--add"}), "--addr\n");
  EXPECT_EQ(After({"--add"}), "--addr\n");
}

TEST(Completion, OffersTheWordsThatAnOptionTakes) {
  EXPECT_EQ(After({"export", "--format", "s"}), "scene\nsdf\n");
  EXPECT_EQ(After({"completion", ""}), "bash\nzsh\nfish\n");
  EXPECT_EQ(After({"distance", "--box", ""}), "") << "numbers are one's own";
}

TEST(Completion, OffersNamesWhereNamesAreMeant) {
  CLI::App app;
  CLI::App* const get = app.add_subcommand("get");
  std::vector<std::string> names;
  get->add_option("NAME", names);
  std::string robot;
  get->add_option("--robot", robot)->type_name("NAME");
  const NameSource known = [](NameKind kind) {
    return kind == NameKind::kRobot ? std::vector<std::string>{"panda"}
                                    : std::vector<std::string>{"mug", "plate"};
  };
  const auto first = CandidatesFor(app, {"get", "m"}, known);
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(first[0].word, "mug");
  EXPECT_EQ(CandidatesFor(app, {"get", "mug", ""}, known).size(), 2u) << "it takes several";
  const auto of_option = CandidatesFor(app, {"get", "--robot", ""}, known);
  ASSERT_EQ(of_option.size(), 1u);
  EXPECT_EQ(of_option[0].word, "panda");
  EXPECT_THAT(CandidatesFor(app, {"get", "mug", "--robot", "x"}, known), IsEmpty());
}

TEST(Completion, KnowsTheOptionsThatAreGiven) {
  CLI::App app;
  std::string world;
  app.add_option("-w,--world", world);
  EXPECT_EQ(OptionValue(app, {"-w", "kitchen", "get", ""}, "--world"), "kitchen");
  EXPECT_EQ(OptionValue(app, {"get", "--world", "kitchen", ""}, "--world"), "kitchen");
  EXPECT_EQ(OptionValue(app, {"get", "--world", "kit"}, "--world"), "") << "being typed";
}

TEST(Completion, HasAScriptForThreeShells) {
  for (const char* shell : {"bash", "zsh", "fish"}) {
    const Printed printed = RunWords({"completion", shell});
    EXPECT_EQ(printed.code, ExitCode::kDone);
    EXPECT_THAT(printed.out, HasSubstr("cwm __complete"));
  }
  const Printed refused = RunWords({"completion", "csh"});
  EXPECT_EQ(refused.code, ExitCode::kUsage);
  EXPECT_THAT(refused.err, HasSubstr("\"csh\" must be bash, zsh or fish"));
}

TEST(NearestWord, IsTheOneWithFewestEdits) {
  EXPECT_EQ(NearestWord("mgu", {"plate", "mug"}), "mug");
  EXPECT_EQ(NearestWord("objct_1", {"object_1", "object_2"}), "object_1");
  EXPECT_EQ(NearestWord("spoon", {"mug", "plate"}), std::nullopt);
  EXPECT_EQ(NearestWord("x", {}), std::nullopt);
  EXPECT_THAT(RunWords({"objcts"}).err, HasSubstr("did you mean objects?"));
}

}  // namespace
}  // namespace cwm::cli
