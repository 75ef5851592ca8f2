// Makes the manual page of a program from its --help.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace cwm::manual {

struct Variable {
  std::string name;
  std::string meaning;
};

struct Facts {
  std::string section = "1";  // 8 for programs that an administrator runs
  std::string version;
  std::vector<Variable> environment = {};  // that the program reads
};

// The manual page in roff, for man. The first line of the application's description is its summary
// ("name: summary" or the summary alone); paragraphs "Examples:" and "Exit codes: N meaning, ..."
// become sections.
std::string ManualPage(const CLI::App& app, const Facts& facts);

// Adds the hidden option --manual-page, which prints that page as --version prints the version.
// `app` must outlive its own parsing.
void AddManualPage(CLI::App& app, Facts facts);

}  // namespace cwm::manual
