#include "clients/cli/run.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <map>
#include <ostream>

#include "clients/cli/closed_pipe.h"
#include "clients/cli/commands.h"
#include "clients/cli/completion.h"
#include "clients/cli/error_report.h"
#include "clients/cli/known_names.h"
#include "clients/cli/nearest_word.h"
#include "clients/cli/one_of.h"
#include "clients/cli/report_command.h"
#include "clients/cpp/call_error.h"
#include "manual/manual_page.h"

namespace cwm::cli {
namespace {

constexpr char kDescription[] =
    "cwm: asks and feeds a collision world model server\n\n"
    "Examples:\n"
    "  cwm ingest scan.pcd                               a scan into the world\n"
    "  cwm objects                                       what is there\n"
    "  cwm distance --box 0.1,0.08,0.2 --at 0.4,0,0.3    how far a gripper is from it\n"
    "  cwm ray --from 0,0,1 --direction 0,0,-1 -o json   one answer for a program\n\n"
    "Exit codes: 0 done, 1 usage, 2 unavailable, 3 not found, 4 revision conflict, 5 deadline or\n"
    "cancelled, 6 permission, 7 resource exhausted, 8 bad input, 10 in collision (--exit-code),\n"
    "11 not known to be free (--exit-code), 70 anything else.";

// Lists each command on one line; its examples are shown by its own --help.
class ShortListFormatter : public CLI::Formatter {
 public:
  std::string make_subcommand(const CLI::App* command) const override {
    const std::string description = command->get_description();
    const std::string summary = description.substr(0, description.find('\n'));
    std::string name = "  " + command->get_name();
    name.resize(std::max<std::size_t>(name.size() + 1, 14), ' ');
    return name + summary + "\n";
  }
};

void AddGlobalOptions(CLI::App& app, Session& session) {
  static const std::map<std::string, OutputForm> kForms = {
      {"table", OutputForm::kTable}, {"json", OutputForm::kJson}, {"ndjson", OutputForm::kNdjson}};
  app.add_option(
         "--addr", session.address,
         std::string("unix:PATH or HOST:PORT of the server; default ") + kDefaultAddressRule)
      ->type_name("ADDR");
  app.add_option("-w,--world", session.world, "the world; default: \"default\"")->type_name("NAME");
  app.add_option("-o,--output", session.form, "table (default), json or ndjson")
      ->transform(OneOf(kForms))
      ->type_name("FORM");
  app.add_option("--deadline", session.deadline_s,
                 "seconds that a call may take; default: no limit")
      ->check(PositiveSeconds)
      ->type_name("S");
}

void AddCommands(CommandLine& line, const report::PageAssets& page_assets) {
  AddStatusCommands(line);
  AddSegmentCommand(line);
  AddReportCommand(line, page_assets);
  AddIngestCommand(line);
  AddStreamCommand(line);
  AddSensorsCommand(line);
  AddObjectCommands(line);
  AddPutCommand(line);
  AddChangeCommands(line);
  AddAttachCommands(line);
  AddRuleCommands(line);
  AddImportCommand(line);
  AddExportCommand(line);
  AddRobotCommands(line);
  AddPairCommands(line);
  AddCheckCommand(line);
  AddMotionCommand(line);
  AddSolveCommand(line);
  AddRayCommand(line);
  AddSampleCommand(line);
  AddWatchCommand(line);
  AddBackupCommand(line);
  AddStoreCommands(line);
  AddBenchCommand(line);
  AddCallCommand(line);
  AddCompletionCommand(line);
  line.app.require_subcommand(1);
}

// An invalid command line must not cause a query to the server.
std::vector<std::string> NoNames(NameKind) { return {}; }

std::vector<std::string> CommandNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const Candidate& command : CandidatesFor(app, {""}, NoNames)) names.push_back(command.word);
  return names;
}

// The last recognised command; the application if there is none.
const CLI::App& ChosenCommand(const CLI::App& app) {
  const CLI::App* chosen = &app;
  while (!chosen->get_subcommands().empty()) chosen = chosen->get_subcommands().front();
  return *chosen;
}

// A suggestion for the first word that looks like an option.
std::optional<std::string> SuggestedOption(const CLI::App& command,
                                           const std::vector<std::string>& words) {
  std::vector<std::string> options;
  for (const Candidate& option : CandidatesFor(command, {"--"}, NoNames)) {
    options.push_back(option.word);
  }
  for (const std::string& word : words) {
    if (word.substr(0, 2) == "--") return NearestWord(word.substr(0, word.find('=')), options);
  }
  return std::nullopt;
}

// A suggestion for an unknown object, robot or world.
std::optional<std::string> Meant(const absl::Status& status, const Session& session) {
  struct Kind {
    NameKind name_kind;
    std::string key;  // in the metadata
  };
  static const std::map<std::string, Kind> kKinds = {
      {"OBJECT_UNKNOWN", {NameKind::kObject, "object"}},
      {"ROBOT_UNKNOWN", {NameKind::kRobot, "robot"}},
      {"WORLD_UNKNOWN", {NameKind::kWorld, "world"}}};
  const client::ErrorDetails details = client::DetailsOf(status);
  const auto kind = kKinds.find(details.reason);
  if (kind == kKinds.end()) return std::nullopt;
  const auto unknown = details.metadata.find(kind->second.key);
  if (unknown == details.metadata.end()) return std::nullopt;
  return NearestWord(unknown->second, KnownNames(session, kind->second.name_kind));
}

// Help and version are not errors; they are printed on stdout.
ExitCode Explain(const CommandLine& line, const CLI::ParseError& error) {
  const Streams& streams = line.session.streams;
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
    line.app.exit(error, streams.out, streams.err);
    return ExitCode::kDone;
  }
  const CLI::App& chosen = ChosenCommand(line.app);
  const std::vector<std::string> unknown = line.app.remaining(/*recurse=*/true);
  // CLI11 only reports that a command is missing.
  const auto any = [](const CLI::App*) { return true; };
  const bool no_command =
      !chosen.get_subcommands(any).empty() && !unknown.empty() && unknown.front().front() != '-';
  FailedCommand failed{.name = &chosen == &line.app ? "" : chosen.get_name(),
                       .address = "",
                       .suggestion = std::nullopt};
  if (chosen.get_parent() != nullptr && chosen.get_parent() != &line.app) {
    failed.name = chosen.get_parent()->get_name() + " " + failed.name;
  }
  if (no_command) {
    failed.suggestion = NearestWord(unknown.front(), CommandNames(chosen));
  } else {
    failed.suggestion = SuggestedOption(chosen, unknown);
  }
  ReportError(UsageError(no_command ? "unknown command '" + unknown.front() + "'" : error.what()),
              failed, streams.err);
  return ExitCode::kUsage;
}

}  // namespace

ExitCode Run(const std::vector<std::string>& arguments, Streams streams,
             const report::PageAssets& page_assets) {
  Session session(streams);
  const char* no_color = std::getenv("NO_COLOR");  // https://no-color.org
  session.no_color = no_color != nullptr && *no_color != '\0';
  CommandLine line{.app = CLI::App(kDescription, "cwm"), .session = session};
  line.app.formatter(std::make_shared<ShortListFormatter>());
  line.app.set_version_flag("--version", "cwm " CWM_VERSION);
  manual::AddManualPage(
      line.app, {.version = CWM_VERSION,
                 .environment = {{"CWM_ADDR", "where the server is, when --addr does not say it"},
                                 {"XDG_RUNTIME_DIR", "where it is otherwise; must be this user's"},
                                 {"NO_COLOR", "when set, tables are plain"}}});
  AddGlobalOptions(line.app, session);
  AddCommands(line, page_assets);
  try {  // CLI11 reports errors by exceptions, which are handled here
    line.app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::ParseError& error) {
    return Explain(line, error);
  }
  streams.out.flush();
  // A reader that closes the pipe is not an error; a full disk is.
  if (line.result.ok() && !streams.out && !IsPipeClosed(streams.out)) {
    line.result = absl::InternalError("stdout cannot be written: part of the answer is lost");
  }
  if (!line.result.ok()) {
    const std::string address = session.address.empty() ? DefaultAddress() : session.address;
    ReportError(line.result, {line.command, address, Meant(line.result, session)}, streams.err);
    return ExitCodeOf(line.result);
  }
  return session.verdict_code;
}

}  // namespace cwm::cli
