// Keeps the worlds of a server in a store: opens it, restores the worlds, journals their changes.
#pragma once

#include <csignal>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/options.h"
#include "server/rpc/runtime.h"
#include "server/store/store_journal.h"

namespace cwm::server {

// The exit code of a process whose store failed while it was used.
inline constexpr int kStoreFailedExitCode = 4;

// Must outlive the application's worlds.
class DurableWorlds {
 public:
  // Opens the store, which no other process may have open. The errors of OpenSqliteStore; their
  // messages say what to do.
  static absl::StatusOr<std::unique_ptr<DurableWorlds>> Open(const Options::Store& options);

  // "sqlite:PATH"
  const std::string& location() const { return location_; }

  // Restores all worlds as they were and journals every change from then on. Meanwhile it moves the
  // progress of the application's gate and tells it to the service manager. Empty if one of the
  // signals, which must be blocked, came first: a replay cannot be interrupted, but the process may
  // end in the midst of it, without running the destructors of what the replay uses. The errors of
  // Replay. If the store fails later, the process ends with kStoreFailedExitCode, since what was not
  // yet answered may be in the store or not.
  std::optional<absl::Status> Restore(Application& application, const sigset_t& signals);

  // Writes what was accepted and closes the store. Must be called after the server has stopped.
  absl::Status Close(Application& application);

 private:
  DurableWorlds(std::string location, bool accept_loss, std::unique_ptr<Store> store)
      : location_(std::move(location)), accept_loss_(accept_loss), store_(std::move(store)) {}

  absl::Status RestoreAll(Application& application);

  const std::string location_;
  const bool accept_loss_;
  std::unique_ptr<Store> store_;  // until the worlds are restored
  std::unique_ptr<StoreJournal> journal_;
};

}  // namespace cwm::server
