#include "clients/cli/run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace cwm::cli {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

struct Outcome {
  ExitCode code;
  std::string out, err;
};

// An address at which no server listens.
constexpr char kNobody[] = "unix:no-such-folder/no-such.sock";

Outcome RunWith(std::vector<std::string> arguments, const std::string& in = "") {
  std::istringstream input(in);
  std::ostringstream out, err;
  arguments.insert(arguments.begin(), {"--addr", kNobody});
  const ExitCode code = Run(arguments, {.in = input, .out = out, .err = err});
  return {code, out.str(), err.str()};
}

TEST(Run, PrintsHelpOnStdoutWithExamplesFirst) {
  const Outcome help = RunWith({"--help"});
  EXPECT_EQ(help.code, ExitCode::kDone);
  EXPECT_LT(help.out.find("Examples:"), help.out.find("Usage"));
  for (const char* command :
       {"status", "segment", "report", "ingest", "stream", "sensors", "objects",  "get",
        "put",    "move",    "remove", "import", "export", "robot",   "distance", "contacts",
        "check",  "ray",     "sample", "watch",  "bench",  "call"}) {
    EXPECT_THAT(help.out, HasSubstr(std::string("  ") + command + " "));
  }
  EXPECT_EQ(help.err, "");
  const Outcome one = RunWith({"distance", "--help"});
  EXPECT_EQ(one.code, ExitCode::kDone);
  EXPECT_LT(one.out.find("cwm distance --box"), one.out.find("--engine"));
}

TEST(Run, BeginsTheHelpOfEveryCommandWithExamples) {
  const auto names = [](std::vector<std::string> words) {
    words.insert(words.begin(), "__complete");
    std::istringstream lines(RunWith(words).out);
    std::vector<std::string> found;
    for (std::string line; std::getline(lines, line);) {
      found.push_back(line.substr(0, line.find('\t')));
    }
    return found;
  };
  std::vector<std::vector<std::string>> commands;
  for (const std::string& name : names({""})) commands.push_back({name});
  for (const char* family : {"robot", "sensors"}) {
    for (const std::string& name : names({family, ""})) commands.push_back({family, name});
  }
  EXPECT_GE(commands.size(), 29u);
  for (std::vector<std::string> command : commands) {
    command.emplace_back("--help");
    const Outcome help = RunWith(command);
    EXPECT_EQ(help.code, ExitCode::kDone) << help.err;
    EXPECT_NE(help.out.find("\n\nExamples:\n  "), std::string::npos) << help.out;
    EXPECT_LT(help.out.find("Examples:"), help.out.find("Usage:")) << help.out;
  }
}

TEST(Run, TellsItsVersionOnStdout) {
  const Outcome version = RunWith({"--version"});
  EXPECT_EQ(version.code, ExitCode::kDone);
  EXPECT_THAT(version.out, ::testing::MatchesRegex("cwm [0-9]+\\.[0-9]+\\.[0-9]+\n"));
  EXPECT_EQ(version.err, "");
}

TEST(Run, MakesNoPagesWithoutWhatTheyAreMadeOf) {
  const Outcome outcome = RunWith({"report", "scan.pcd", "scan.html"});
  EXPECT_EQ(outcome.code, ExitCode::kOther);
  EXPECT_THAT(outcome.err, HasSubstr("built without the pages"));
}

TEST(Run, RefusesAPageOfAnotherNameBeforeItReadsTheScan) {
  for (const char* file : {"scan.pcd", "scan", "scan.html.gz"}) {
    std::istringstream in;
    std::ostringstream out, err;
    const ExitCode code =
        cli::Run({"report", "no-such-scan.pcd", file}, {.in = in, .out = out, .err = err},
                 {.script = "s", .style = "s"});
    EXPECT_EQ(code, ExitCode::kUsage) << file;
    EXPECT_THAT(err.str(), HasSubstr(std::string("OUT: \"") + file + "\" must end in .html"));
  }
}

TEST(Run, RefusesAMeshFileOfAnotherFormatBeforeItAsksTheServer) {
  for (const char* file : {"mug.stl", "mug", "glb", "mug.ply.gz"}) {
    const Outcome outcome = RunWith({"get", "mug", "--mesh", file});
    EXPECT_EQ(outcome.code, ExitCode::kUsage) << file;
    EXPECT_THAT(outcome.err,
                HasSubstr(std::string("--mesh: \"") + file + "\" must end in .ply or .glb"));
  }
}

TEST(Run, RefusesToWriteALabelledCloudUnderTheNameOfAnotherFormat) {
  const Outcome segment = RunWith({"segment", "no-such-file.pcd", "out.ply"});
  EXPECT_EQ(segment.code, ExitCode::kUsage);
  EXPECT_THAT(segment.err, HasSubstr("OUT: \"out.ply\" must end in .pcd"));
  const Outcome ingest = RunWith({"ingest", "no-such-file.pcd", "--labels", "out.ply"});
  EXPECT_EQ(ingest.code, ExitCode::kUsage);
  EXPECT_THAT(ingest.err, HasSubstr("--labels: \"out.ply\" must end in .pcd"));
  EXPECT_EQ(RunWith({"segment", "no-such-file.pcd", "/dev/stdout"}).code, ExitCode::kBadInput);
}

TEST(Run, NamesTheWordsThatAnOptionTakes) {
  EXPECT_THAT(
      RunWith({"objects", "--kind", "spoon"}).err,
      HasSubstr("--kind: \"spoon\" must be mover, object, residual, support, unseen or user\n"));
  EXPECT_THAT(RunWith({"objects", "-o", "xml"}).err,
              HasSubstr("\"xml\" must be json, ndjson or table\n"));
  // Numbers are not accepted as names of enum values.
  EXPECT_EQ(RunWith({"check", "--sphere", "1", "--at", "0,0,0", "--engine", "2"}).code,
            ExitCode::kUsage);
  EXPECT_EQ(RunWith({"check", "--sphere", "1", "--at", "0,0,0", "--engine", "FCL"}).code,
            ExitCode::kUnavailable);
}

TEST(Run, EndsWithUsageOnMistakesOfTheCommandLine) {
  const std::vector<std::vector<std::string>> mistakes = {
      {},
      {"fly"},
      {"objects", "--kind", "spoon"},
      {"objects", "-o", "xml"},
      {"distance", "--box", "1,2", "--at", "0,0,0"},
      {"distance", "--box", "1,2,x", "--at", "0,0,0"},
      {"distance", "--box", "1,2,3", "--sphere", "1", "--at", "0,0,0"},
      {"distance", "--box", "1,2,3", "--object", "cup", "--at", "0,0,0"},
      {"distance", "--sphere", "1", "--at", "0,0"},
      {"distance", "--sphere", "1", "--at", "0,0,0", "--engine", "magic"},
      {"distance", "--sphere", "1", "--at", "0,0,0", "--at-revision", "yesterday"},
      {"ray", "--from", "0,0,0"},
      {"sample", "0,0"},
      {"sample", "0,0,0", "cup+0,0"},
      {"ray", "--from", "cup+0,0", "--direction", "0,0,1"},
      {"ray", "--from", "0,0,0", "--to", "1,1,1", "--direction", "1,0,0"},
      {"move", "cup"},
      {"move", "cup", "--at", "0,0,1", "--to", "0,0,1"},
      {"robot", "set", "panda"},
      {"stream"},
      {"stream", "no-such-folder", "--mount", "panda"},
      {"stream", "no-such-folder", "--mount", "/hand"},
      {"stream", "no-such-folder", "--mount", "panda/hand", "--x-world-sensor", "0,0,0"},
      {"stream", "no-such-folder", "--mount", "panda:hand", "--x-world-sensor", "0,0,0"},
      {"stream", "no-such-folder", "--x-link-sensor", "0,0,0"},
      {"stream", "no-such-folder", "--rate", "0"},
      {"stream", "no-such-folder", "--loop", "-1"},
      {"stream", "-", "--loop", "2"},
      {"sensors", "set"},
      {"sensors", "set", "table"},
      {"sensors", "set", "table", "--estimate", "--x-world-sensor", "0,0,0"},
      {"check", "--robot", "panda", "--at", "0,0,0", "--x-world-base", "0,0,0"},
      {"put", "cup"},
      {"segment", "in.pcd"},
      {"status", "--deadline", "-1"},
      {"ingest", "a.pcd", "b.pcd", "--labels", "out.pcd"},
      {"ingest", "a.pcd", "--sensor-model", "sonar"},
      {"ingest", "a.pcd", "--clusters", "blobs"},
      {"bench", "--seconds", "0"},
      {"bench", "--seconds", "nan"},
      {"bench", "--seconds", "601"},
      {"bench", "--batch", "0"},
      {"bench", "--batch", "many"},
      {"bench", "--writes", "--world", "kitchen"},
      {"bench", "--writes", "--robot", "panda"},
  };
  for (const auto& mistake : mistakes) {
    const Outcome outcome = RunWith(mistake);
    EXPECT_EQ(outcome.code, ExitCode::kUsage) << ::testing::PrintToString(mistake) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("cwm: usage: "), HasSubstr("hint: ")));
    EXPECT_EQ(outcome.out, "");
  }
}

TEST(Run, SaysWhatAMistypedWordWasPerhapsToBe) {
  EXPECT_THAT(RunWith({"objekts"}).err, HasSubstr("did you mean objects?"));
  EXPECT_THAT(RunWith({"robot", "lod", "x"}).err,
              AllOf(HasSubstr("unknown command 'lod'"), HasSubstr("did you mean load?")));
  EXPECT_THAT(RunWith({"check", "--objct", "mug"}).err, HasSubstr("did you mean --object?"));
  EXPECT_THAT(RunWith({"check", "--objct=mug"}).err, HasSubstr("did you mean --object?"));
  EXPECT_THAT(RunWith({"--wrld", "kitchen", "status"}).err, HasSubstr("did you mean --world?"));
  EXPECT_THAT(RunWith({"robot", "get", "--nme", "x"}).err, HasSubstr("`cwm robot get --help`"));
  EXPECT_THAT(RunWith({"completion", "bash", "more"}).err, Not(HasSubstr("unknown command")));
  EXPECT_THAT(RunWith({"put"}).err, AllOf(HasSubstr("NAME is required"), HasSubstr("`cwm put ")));
}

TEST(Run, SaysThatNoServerListensAndWhatToDo) {
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"status"},
           {"info"},
           {"objects"},
           {"get", "cup"},
           {"remove", "cup"},
           {"move", "cup", "--by", "-0.1,0,0"},
           {"put", "cup", "--cone", "0.03,0.04,0.1", "--at", "-0.1,0,0"},
           {"distance", "--sphere", "0.1", "--at", "-1,-2,-3", "--at", "0,0,1,0,0,0,1"},
           {"check", "--object", "cup"},
           {"contacts", "--capsule", "0.1,0.2", "--at", "0,0,0", "-o", "json"},
           {"ray", "--from", "-1,0,0", "--direction", "-1,0,0"},
           {"sample", "-1,0,0", "-0.5,0,0"},
           {"watch"},
           {"bench"},
           {"call", "GetServerInfo"}}) {
    const Outcome outcome = RunWith(command);
    EXPECT_EQ(outcome.code, ExitCode::kUnavailable)
        << ::testing::PrintToString(command) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("cwm: server unavailable"), HasSubstr(kNobody),
                                   HasSubstr("cwm-server")));
    EXPECT_EQ(outcome.out, "");
  }
}

TEST(Run, TakesFormerNamesOfOptionsAndShowsThePresentOnes) {
  const std::vector<std::vector<std::string>> commands = {
      {"move", "cup", "--to", "0,0,1"},
      {"robot", "set", "panda", "--x-world-base", "0,0,1"},
      {"check", "--robot", "panda", "--x-world-base", "0,0,1"}};
  for (const std::vector<std::string>& command : commands) {
    EXPECT_EQ(RunWith(command).code, ExitCode::kUnavailable) << ::testing::PrintToString(command);
    const std::string& former = command[command.size() - 2];
    std::vector<std::string> help(command.begin(), command.end() - 2);
    help.emplace_back("--help");
    EXPECT_THAT(RunWith(help).out, AllOf(HasSubstr("--at "), Not(HasSubstr(former))));
    EXPECT_THAT(RunWith({"__complete", command[0], "--"}).out, Not(HasSubstr(former)));
  }
}

TEST(Run, CallsFilesThatCannotBeReadBadInput) {
  EXPECT_EQ(RunWith({"ingest", "no-such-file.pcd"}).code, ExitCode::kBadInput);
  EXPECT_EQ(RunWith({"import", "no-such-file.yaml"}).code, ExitCode::kBadInput);
  const Outcome folder = RunWith({"ingest", "/"});
  EXPECT_EQ(folder.code, ExitCode::kBadInput);
  EXPECT_THAT(folder.err, HasSubstr("not a regular file"));
}

TEST(Run, NamesTheLineOfStdinThatIsWrong) {
  const Outcome outcome =
      RunWith({"distance"}, "{\"sphere\": 0.1, \"at\": [0, 0, 0]}\n{\"sphere\": 0.1}\n");
  EXPECT_EQ(outcome.code, ExitCode::kBadInput);
  EXPECT_THAT(outcome.err, HasSubstr("stdin line 2: \"at\" is missing"));
}

TEST(Run, WritesNoColourWhenNotOnATerminal) {
  EXPECT_THAT(RunWith({"--help"}).out, Not(HasSubstr("\033")));
  EXPECT_THAT(RunWith({"status"}).err, Not(HasSubstr("\033")));
}

}  // namespace
}  // namespace cwm::cli
