// Adds commands to the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "clients/cli/session.h"

namespace cwm::cli {

struct CommandText {
  std::string name;
  std::string summary;                // one line, shown in the list of commands
  std::vector<std::string> examples;  // shown first by --help
  std::string details = {};           // after the examples
};

// The application with the commands' actions and their result.
struct CommandLine {
  CLI::App app;
  Session& session;
  std::string command = {};  // the command that ran
  absl::Status result = absl::OkStatus();
};

// Adds a command whose action runs once its options are parsed. The options' storage must live as
// long as the action, so commands share it with them.
CLI::App& AddCommand(CommandLine& line, const CommandText& text,
                     std::function<absl::Status(Session&)> action);
// The same below a family of commands (`cwm robot load`) made by AddFamily.
CLI::App& AddCommand(CommandLine& line, CLI::App& family, const CommandText& text,
                     std::function<absl::Status(Session&)> action);
CLI::App& AddFamily(CommandLine& line, const CommandText& text);

// Accepts a former name of an option, which help, manual and completion no longer show. It is a
// usage error to give both.
void AddFormerName(CLI::App& command, const std::string& name, std::string& value,
                   CLI::Option* option);

}  // namespace cwm::cli
