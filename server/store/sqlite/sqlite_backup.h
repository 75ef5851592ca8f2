// A backup is the directory of a store that was closed: store.db, head and the blobs in use. It is
// made in the store's directory, with hard links to the blobs.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/store/sqlite/sqlite_handles.h"
#include "server/store/store.h"

namespace cwm::server {

class SqliteEngine;

struct FinishBackup {
  void operator()(sqlite3_backup* backup) const;
};

// Must not outlive the engine's use by its thread: the engine abandons it when it is closed.
class SqliteBackupRun final : public Store::BackupRun {
 public:
  static absl::StatusOr<std::unique_ptr<BackupRun>> Start(SqliteEngine& engine);
  ~SqliteBackupRun() override;
  absl::StatusOr<std::unique_ptr<Backup>> Step() override;
  // Ends the copying; what was copied is removed, and each later step is an error.
  void Abandon();

 private:
  SqliteBackupRun(SqliteEngine& engine, std::string folder);
  absl::Status Prepare();
  // Links at most `count` blobs in use that are not linked yet; true if there are no more.
  absl::StatusOr<bool> LinkBlobs(std::size_t count);
  absl::StatusOr<std::unique_ptr<Backup>> Finish();

  SqliteEngine* engine_;
  std::string folder_;
  Database copy_;
  std::unique_ptr<sqlite3_backup, FinishBackup> copying_;
  std::vector<std::string> linked_;  // paths in the store's directory, sorted
};

}  // namespace cwm::server
