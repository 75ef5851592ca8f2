// cwm completion, and the hidden command that its scripts run
#include <memory>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "clients/cli/commands.h"
#include "clients/cli/completion.h"
#include "clients/cli/exit_code.h"

namespace cwm::cli {
namespace {

absl::Status PrintScript(Session& session, const std::string& shell) {
  const char* const script = CompletionScript(shell);
  if (script == nullptr) {
    return UsageError(absl::StrCat("SHELL: \"", shell, "\" must be bash, zsh or fish"));
  }
  session.streams.out << script;
  return absl::OkStatus();
}

// Prints "WORD\tDESCRIPTION" per line, as fish expects it.
absl::Status PrintCandidates(const CLI::App& app, const std::vector<std::string>& words,
                             Session& session) {
  if (std::string given = OptionValue(app, words, "--addr"); !given.empty())
    session.address = given;
  if (std::string given = OptionValue(app, words, "--world"); !given.empty()) session.world = given;
  const NameSource names = [&](NameKind kind) { return KnownNames(session, kind); };
  for (const Candidate& each : CandidatesFor(app, words, names)) {
    session.streams.out << each.word << "\t" << each.description << "\n";
  }
  return absl::OkStatus();
}

}  // namespace

void AddCompletionCommand(CommandLine& line) {
  const auto shell = std::make_shared<std::string>();
  CLI::App& command = AddCommand(
      line,
      {"completion",
       "a script that lets bash, zsh or fish complete commands, options and names",
       {"source <(cwm completion bash)", "source <(cwm completion zsh)",
        "cwm completion fish | source"},
       "It lasts as long as the shell: for good, put the line into ~/.bashrc, into ~/.zshrc "
       "after compinit,\n"
       "or into ~/.config/fish/config.fish. Names of objects, robots and worlds are asked "
       "of the server\n"
       "while one types; CWM_ADDR says which."},
      [shell](Session& session) { return PrintScript(session, *shell); });
  command.add_option("SHELL", *shell, "bash, zsh or fish")->required()->type_name("bash|zsh|fish");

  // All words after it are taken literally.
  CLI::App* const asked = line.app.add_subcommand("__complete", "what may follow the words");
  asked->group("")->prefix_command();
  asked->callback([&line, asked] {
    line.command = asked->get_name();
    line.result = PrintCandidates(line.app, asked->remaining(), line.session);
  });
}

}  // namespace cwm::cli
