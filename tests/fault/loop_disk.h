// A disk whose power can be cut: ext4 on a loop device, in a mount namespace of this process, so
// that nothing stays mounted when it ends. Needs root.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tests/support/process.h"

namespace cwm::fault {

class LoopDisk {
 public:
  // Unavailable if this machine or this user cannot do it. Call it, and all functions, from the
  // main thread: servers that it starts later see the disk.
  static absl::StatusOr<std::unique_ptr<LoopDisk>> Make(std::int64_t bytes);
  ~LoopDisk();

  // The mounted directory.
  const std::string& path() const { return path_; }

  // Stops all writing to the device at once: what was not flushed is lost.
  absl::Status Cut();
  // Unmounts and mounts again, which replays the file system's journal. No file may be open.
  absl::Status Remount();
  // Fills it with a file until no byte is left; Empty removes the file.
  absl::Status Fill();
  void Empty();

 private:
  LoopDisk() = default;
  absl::Status Mount() const;

  testing::ScratchDirectory scratch_;
  std::string image_ = scratch_ / "image";
  std::string path_ = scratch_ / "disk";
};

}  // namespace cwm::fault
