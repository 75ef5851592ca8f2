// The store that keeps a server's worlds, as its administration sees it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace cwm::server {

struct StoreInfo {
  std::int64_t sequence = 0;  // of the newest record; records of all worlds are numbered together
  std::int64_t epoch = 0;     // how often the store was opened by a server
  std::int64_t record_count = 0;  // records that are not yet folded into a snapshot of their world
  std::int64_t bytes = 0;         // of all files
  std::int64_t blob_count = 0;
  std::string refuses_writes = {};  // why writes are refused at present, or empty
};

// One file of a copy of the store.
struct BackupFile {
  std::string path;    // relative to the store's directory
  std::string source;  // where its bytes are read; they do not change while the backup exists
};

// A consistent copy of a store. Its files stay, while the store goes on, until it is destroyed,
// which any thread may do.
class Backup {
 public:
  virtual ~Backup() = default;
  virtual const std::vector<BackupFile>& files() const = 0;
  virtual std::int64_t sequence() const = 0;  // of the newest record in it
};

// Thread safe.
class StoreAdmin {
 public:
  virtual ~StoreAdmin() = default;

  // Does not wait for the disk.
  virtual StoreInfo info() const = 0;

  using BackupDone = std::function<void(absl::StatusOr<std::shared_ptr<const Backup>> backup)>;
  // Begins a copy of the store, which is made in short steps between writes, and returns at once.
  // Calls `done` once, from any thread, when the copy is complete. ResourceExhausted DISK_FULL if
  // there is no room for a copy; Unavailable SERVER_DRAINING if the store closes first. The caller
  // makes one backup at a time.
  virtual void StartBackup(BackupDone done) = 0;
};

}  // namespace cwm::server
