// The file `head`: which records were acknowledged. SQLite drops the end of a damaged log without a
// word; the head tells that records are missing.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/store/sqlite/store_files.h"

namespace cwm::server {

struct Head {
  std::int64_t last = 0;     // the newest record: it survives the end of the process
  std::int64_t durable = 0;  // the newest record that also survives a power cut
};

// DataLoss STORE_DAMAGED if the file is not as it was written.
absl::StatusOr<Head> ReadHead(const std::string& path);

// Written in place after each commit and not synced: after a power cut it is at most older.
class HeadFile {
 public:
  // Creates the file, durably, if there is none.
  static absl::StatusOr<HeadFile> Open(const std::string& path);
  absl::Status Write(const Head& head);
  absl::Status Sync();

 private:
  std::string path_;
  FileDescriptor file_;
};

}  // namespace cwm::server
