// The manual page of a program, made of what its --help says.
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
  std::string section = "1";  // 8 for what an administrator runs
  std::string version;
  std::vector<Variable> environment = {};  // what it reads
};

// In roff, for man. The first line of the application's description is its summary ("name: summary"
// or the summary alone); paragraphs "Examples:" and "Exit codes: N meaning, ..." become sections.
std::string ManualPage(const CLI::App& app, const Facts& facts);

// The option --manual-page, which no help shows and which prints that page as --version prints the
// version. `app` must outlive its own parsing, as it does.
void AddManualPage(CLI::App& app, Facts facts);

}  // namespace cwm::manual
