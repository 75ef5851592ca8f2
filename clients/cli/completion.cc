#include "clients/cli/completion.h"

#include <algorithm>
#include <map>
#include <optional>

#include "absl/strings/match.h"
#include "absl/strings/str_split.h"

namespace cwm::cli {
namespace {

std::string FirstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

// The place that the words lead to, without the last word, which is being typed.
struct CompletionContext {
  const CLI::App* command;
  const CLI::Option* awaits = nullptr;  // an option whose value is next
  std::size_t positionals = 0;          // number of positionals given already
};

const CLI::App* SubcommandOf(const CLI::App& app, const std::string& name) {
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == name) return command;
  }
  return nullptr;
}

// The option of the command, or a global option of the commands above it.
const CLI::Option* FindOption(const CLI::App* command, const std::string& word) {
  for (; command != nullptr; command = command->get_parent()) {
    for (const CLI::Option* option : command->get_options()) {
      if (absl::StartsWith(word, "-") && option->check_name(word)) return option;
    }
  }
  return nullptr;
}

CompletionContext ParseContext(const CLI::App& app, const std::vector<std::string>& words) {
  CompletionContext context{&app};
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const std::string& word = words[i];
    if (context.awaits != nullptr) {
      context.awaits = nullptr;
    } else if (absl::StartsWith(word, "-")) {
      const CLI::Option* const option =
          FindOption(context.command, word);  // nullptr: "--option=value"
      if (option != nullptr && option->get_items_expected_max() > 0) context.awaits = option;
    } else if (const CLI::App* const below = SubcommandOf(*context.command, word)) {
      context.command = below;
    } else {
      ++context.positionals;
    }
  }
  return context;
}

// The words of a type such as "glb|ply", which are typed as they are written.
std::vector<std::string> WordsOfType(const std::string& type) {
  const auto is_of_word = [](char c) { return (c >= 'a' && c <= 'z') || c == '_' || c == '|'; };
  if (!absl::StrContains(type, "|") || !std::all_of(type.begin(), type.end(), is_of_word))
    return {};
  return absl::StrSplit(type, '|');
}

std::optional<NameKind> NamesFor(const CLI::Option& option, const CLI::App& command) {
  const std::string name = option.get_name(true, true);
  if (absl::StrContains(name, "--world") && !absl::StrContains(name, "frame"))
    return NameKind::kWorld;
  if (absl::StrContains(name, "--robot")) return NameKind::kRobot;
  const bool is_of_robots =
      command.get_parent() != nullptr && command.get_parent()->get_name() == "robot";
  if (option.get_positional() && option.get_name() == "NAME") {
    return is_of_robots ? NameKind::kRobot : NameKind::kObject;
  }
  if (option.get_name() == "A" || option.get_name() == "B") return NameKind::kObject;
  if (option.check_name("--at") || option.check_name("--ignore") || option.check_name("--only")) {
    return NameKind::kObject;
  }
  return std::nullopt;
}

std::vector<Candidate> ValuesOf(const CLI::Option& option, const CLI::App& command,
                                const NameSource& names) {
  std::vector<Candidate> values;
  for (const std::string& word : WordsOfType(option.get_type_name())) values.push_back({word, ""});
  if (const std::optional<NameKind> kind = NamesFor(option, command)) {
    for (const std::string& name : names(*kind)) values.push_back({name, ""});
  }
  return values;
}

std::vector<Candidate> OptionsOf(const CLI::App* command) {
  std::vector<Candidate> options;
  for (; command != nullptr; command = command->get_parent()) {
    for (const CLI::Option* option : command->get_options()) {
      if (option->get_group().empty()) continue;  // hidden
      for (const std::string& name : option->get_lnames()) {
        options.push_back({"--" + name, FirstLine(option->get_description())});
      }
    }
  }
  return options;
}

std::vector<Candidate> CommandsOf(const CLI::App& app) {
  std::vector<Candidate> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_group().empty()) continue;  // hidden
    commands.push_back({command->get_name(), FirstLine(command->get_description())});
  }
  return commands;
}

// The next positional; the last one may take all further words.
const CLI::Option* PositionalOf(const CompletionContext& context) {
  const auto positionals = context.command->get_options(
      [](const CLI::Option* option) { return option->get_positional(); });
  if (positionals.empty()) return nullptr;
  const bool is_one_more = context.positionals >= positionals.size();
  if (is_one_more && positionals.back()->get_items_expected_max() <= 1) return nullptr;
  return is_one_more ? positionals.back() : positionals[context.positionals];
}

std::vector<Candidate> AllCandidates(const CompletionContext& context, const std::string& word,
                                     const NameSource& names) {
  if (context.awaits != nullptr) return ValuesOf(*context.awaits, *context.command, names);
  if (absl::StartsWith(word, "-")) return OptionsOf(context.command);
  std::vector<Candidate> commands = CommandsOf(*context.command);
  if (!commands.empty()) return commands;
  const CLI::Option* const positional = PositionalOf(context);
  return positional == nullptr ? std::vector<Candidate>()
                               : ValuesOf(*positional, *context.command, names);
}

}  // namespace

std::vector<Candidate> CandidatesFor(const CLI::App& app, const std::vector<std::string>& words,
                                     const NameSource& names) {
  const std::string word = words.empty() ? "" : words.back();
  std::vector<Candidate> candidates = AllCandidates(ParseContext(app, words), word, names);
  std::erase_if(candidates,
                [&](const Candidate& each) { return !absl::StartsWith(each.word, word); });
  return candidates;
}

std::string OptionValue(const CLI::App& app, const std::vector<std::string>& words,
                        const std::string& option) {
  const CLI::Option* const wanted = app.get_option(option);
  std::string value;
  for (std::size_t i = 0; i + 2 < words.size(); ++i) {  // the last word is being typed
    const bool is_it = absl::StartsWith(words[i], "-") && wanted->check_name(words[i]);
    if (is_it) value = words[i + 1];
  }
  return value;
}

const char* CompletionScript(const std::string& shell) {
  static const std::map<std::string, const char*> scripts = {{"bash", R"script(# cwm completion bash
_cwm() {
  local IFS=$'\n'
  COMPREPLY=($(cwm __complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null | cut -f1))
}
complete -o default -F _cwm cwm
)script"},
                                                             {"zsh", R"script(#compdef cwm
# cwm completion zsh
_cwm() {
  local line
  local -a candidates
  for line in "${(@f)$(cwm __complete "${(@)words[2,CURRENT]}" 2>/dev/null)}"; do
    [[ -n $line ]] && candidates+=("${${line%%$'\t'*}//:/\\:}:${line#*$'\t'}")
  done
  if (( $#candidates )); then
    _describe cwm candidates
  else
    _files
  fi
}
if [[ $funcstack[1] == _cwm ]]; then  # loaded by the first completion
  _cwm "$@"
else
  compdef _cwm cwm
fi
)script"},
                                                             {"fish", R"script(# cwm completion fish
complete -c cwm -k -a '(cwm __complete (commandline -opc)[2..-1] (commandline -ct) 2>/dev/null)'
)script"}};
  const auto found = scripts.find(shell);
  return found == scripts.end() ? nullptr : found->second;
}

}  // namespace cwm::cli
