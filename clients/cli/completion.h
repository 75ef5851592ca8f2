// Completes a command line that is being typed.
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

using NameSource = std::function<std::vector<std::string>(NameKind)>;

// The possible completions of the last word, which may be empty: commands, options, words that an
// option takes, and names known to the server. None if a file or a free value is expected. `words`
// are those after the program's name.
std::vector<Candidate> CandidatesFor(const CLI::App& app, const std::vector<std::string>& words,
                                     const NameSource& names);

// The value of a global option in the words, given as "--world" or "-w"; empty: none.
std::string OptionValue(const CLI::App& app, const std::vector<std::string>& words,
                        const std::string& option);

// The script that a shell evaluates; it runs `cwm __complete WORD...` for each completion. nullptr
// for shells other than bash, zsh and fish.
const char* CompletionScript(const std::string& shell);

}  // namespace cwm::cli
