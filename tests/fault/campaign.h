// The state of a campaign, which is kept in build/fault/NAME.json, so that it can be interrupted
// and resumed.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/fault/checker.h"
#include "tests/fault/history.h"

namespace cwm::fault {

struct Settings {
  std::string server = {};                             // the program cwm-server
  std::string directory = {};                          // of the states of campaigns
  std::int64_t count = 0;                              // what all runs together shall reach
  std::chrono::seconds time = std::chrono::hours(24);  // of this run
  // The server's flushes do nothing: power cuts must then find lost writes, which proves the cuts.
  bool syncs_lie = false;
  bool in_memory = false;  // for work on the checker: a server without a store, and without kills
};

class Campaign {
 public:
  // Goes on from the kept state, or begins anew with `fresh`.
  Campaign(std::string name, const Settings& settings, bool fresh);

  const Settings& settings() const { return settings_; }
  std::int64_t Count(const std::string& what) const;
  void Add(const std::string& what, std::int64_t count = 1) { counts_[what] += count; }
  // Adds what the report counts and the one before did not.
  void AddReport(const Report& report, const Report& before);

  // True until the count is reached or the time is over.
  bool GoesOn(const std::string& what) const;
  // Starts at 1 and differs for each trial of all runs.
  std::uint32_t NextSeed();

  // Keeps a violation, with the history and a copy of the store beside the state. Only the first
  // ones are kept whole.
  void Complain(const std::string& text, const History& history, std::uint32_t seed,
                const std::string& store);
  void Complain(const std::string& text);
  bool has_violations() const { return Count("violations") > 0; }

  // Writes the state.
  void Save() const;
  // One line with all counts.
  std::string Summary() const;
  // Prints it, unless it was printed last.
  void Print();

 private:
  std::string PathOf(const std::string& file) const;

  std::string name_;
  Settings settings_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::map<std::string, std::int64_t> counts_;
  std::vector<std::string> violations_;
  std::string printed_;
  std::uint32_t kept_seed_ = 0;  // of the newest history in a file
};

}  // namespace cwm::fault
