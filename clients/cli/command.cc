#include "clients/cli/command.h"

#include <utility>

namespace cwm::cli {

CLI::App& AddCommand(CommandLine& line, const CommandText& text,
                     std::function<absl::Status(Session&)> action) {
  std::string description = text.summary + "\n\nExamples:\n";
  for (const std::string& example : text.examples) description += "  " + example + "\n";
  if (!text.details.empty()) description += "\n" + text.details + "\n";
  CLI::App* command = line.app.add_subcommand(text.name, description);
  command->fallthrough();  // global options may follow the command
  command->callback([&line, name = text.name, action = std::move(action)] {
    line.command = name;
    line.result = action(line.session);
  });
  return *command;
}

}  // namespace cwm::cli
