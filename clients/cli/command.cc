#include "clients/cli/command.h"

#include <utility>

namespace cwm::cli {

namespace {

CLI::App& AddSubcommand(CLI::App& parent, const CommandText& text) {
  std::string description = text.summary + "\n\nExamples:\n";
  for (const std::string& example : text.examples) description += "  " + example + "\n";
  if (!text.details.empty()) description += "\n" + text.details + "\n";
  CLI::App* command = parent.add_subcommand(text.name, description);
  command->fallthrough();  // lets global options follow the command
  return *command;
}

CLI::App& AddNamed(CommandLine& line, CLI::App& parent, const CommandText& text,
                   const std::string& name, std::function<absl::Status(Session&)> action) {
  CLI::App& command = AddSubcommand(parent, text);
  command.callback([&line, &command, name, action = std::move(action)] {
    if (!command.get_subcommands().empty()) return;  // the command below it has run
    line.command = name;
    line.result = action(line.session);
  });
  return command;
}

}  // namespace

CLI::App& AddCommand(CommandLine& line, const CommandText& text,
                     std::function<absl::Status(Session&)> action) {
  return AddNamed(line, line.app, text, text.name, std::move(action));
}

CLI::App& AddCommand(CommandLine& line, CLI::App& family, const CommandText& text,
                     std::function<absl::Status(Session&)> action) {
  return AddNamed(line, family, text, family.get_name() + " " + text.name, std::move(action));
}

CLI::App& AddFamily(CommandLine& line, const CommandText& text) {
  CLI::App& family = AddSubcommand(line.app, text);
  family.require_subcommand(1);
  return family;
}

void AddFormerName(CLI::App& command, const std::string& name, std::string& value,
                   CLI::Option* option) {
  const auto take = [&value, name, option](const std::string& text) {
    if (option->count() > 0) {  // not `excludes`, which the help of both would show
      throw CLI::ValidationError(name + " is the former name of " + option->get_name(), "give one");
    }
    value = text;
  };
  command.add_option_function<std::string>(name, take)->group("");
}

}  // namespace cwm::cli
