// One store under one workload: started, broken, started again, and checked at last.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/fault/campaign.h"
#include "tests/fault/server_process.h"
#include "tests/fault/workload.h"

namespace cwm::fault {

class Trial {
 public:
  // `store_directory`: empty for one of its own, which ends with the trial.
  Trial(Campaign& campaign, const WorkloadOptions& options,
        const std::string& store_directory = {});

  // Starts a server on the store, after the end of the one before. False, and a violation of the
  // campaign, if it does not come up; with `may_end`, because a fault awaits it, an end is no
  // violation.
  bool Boot(std::vector<std::string> environment = {}, bool may_end = false);
  // Of all servers that are started from now on.
  void SetEnvironment(std::vector<std::string> environment) {
    environment_ = std::move(environment);
  }
  // After the first Boot: makes the world.
  bool Prepare();
  // Looks at what the restart brought back. False, and a violation, if it cannot; `may_end` as
  // above.
  bool InspectRestart(bool whole = false, bool may_end = false);
  // Lets the clients finish, compares the world with what two restarts bring back, one after
  // SIGTERM and one after SIGKILL.
  void Conclude();
  // Checks the history so far and adds what it counts to the campaign. Violations break the trial:
  // what follows would be found again and again.
  void CheckHistory();

  // Reads a backup of the store and drops it. From any thread, while the server runs or ends.
  void BackUp() const;

  void Complain(const std::string& text);

  ServerProcess& server() { return *server_; }
  Workload& workload() { return workload_; }
  const std::string& store() const { return store_; }
  const testing::ScratchDirectory& scratch() const { return scratch_; }
  // The server does not come up, or the history has violations: nothing more can be tried.
  bool is_broken() const { return is_broken_; }

 private:
  Campaign& campaign_;
  testing::ScratchDirectory scratch_;
  std::string store_;
  std::vector<std::string> environment_;
  std::uint32_t seed_;
  Workload workload_;
  std::unique_ptr<ServerProcess> server_;
  Report report_;
  bool is_broken_ = false;
};

}  // namespace cwm::fault
