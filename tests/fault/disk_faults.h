// What the preloaded library does to the writes of a server, shared with it through a file.
#pragma once

#include <atomic>
#include <cstdint>

namespace cwm::fault {

enum class DiskFault : std::int32_t {
  kNone,
  kSyncFails,   // fsync and fdatasync: EIO
  kWriteFails,  // write and pwrite: EIO
  kFull,        // nothing can be written: ENOSPC, and no space is said to be free
  kShort,       // half of what was to be written is, if it is more than a sector: no error
  kTorn,        // half of what a file was to grow by is written, then the disk is full
  kSyncLies,    // fsync and fdatasync do nothing: a power cut must then lose writes
};

// The environment of the server: CWM_DISK_FAULTS names the file with this content, and
// CWM_DISK_PATH begins the path of each file that is concerned.
struct DiskFaults {
  std::atomic<DiskFault> fault = DiskFault::kNone;
  std::atomic<std::int64_t> calls_before = 0;  // that still succeed
  std::atomic<std::int64_t> hits = 0;          // calls that failed or did less
};

}  // namespace cwm::fault
