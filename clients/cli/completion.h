// What may follow on a command line that is being typed.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "clients/cli/known_names.h"

namespace cwm::cli {

struct Candidate {
  std::string word;
  std::string description;  // one line; may be empty
};

using NameSource = std::function<std::vector<std::string>(Named)>;

// What the last of the words, which may be empty, can become: commands, options, the words that an
// option takes, and names that the server knows. Nothing where a file or a value of one's own is
// meant. `words` are those after the program's name.
std::vector<Candidate> CandidatesFor(const CLI::App& app, const std::vector<std::string>& words,
                                     const NameSource& names);

// The value of an option of all commands that the words give, as "--world", "-w"; empty: none.
std::string ValueGiven(const CLI::App& app, const std::vector<std::string>& words,
                       const std::string& option);

// The script that a shell evaluates: it asks `cwm __complete WORD...` each time. nullptr for a
// shell that is not bash, zsh or fish.
const char* CompletionScript(const std::string& shell);

}  // namespace cwm::cli
