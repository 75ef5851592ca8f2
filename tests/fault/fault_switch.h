// Turns the faults of the preloaded library on and off, from outside of the server.
#pragma once

#include <string>
#include <vector>

#include "tests/fault/disk_faults.h"

namespace cwm::fault {

class FaultSwitch {
 public:
  // `file` is made; `directory` holds the files whose writes can fail.
  FaultSwitch(const std::string& file, const std::string& directory);
  ~FaultSwitch();
  FaultSwitch(const FaultSwitch&) = delete;
  FaultSwitch& operator=(const FaultSwitch&) = delete;

  // For the server.
  const std::vector<std::string>& environment() const { return environment_; }

  void Set(DiskFault fault, std::int64_t calls_before);
  void Clear() { Set(DiskFault::kNone, 0); }
  std::int64_t hits() const { return faults_->hits; }

 private:
  DiskFaults* faults_ = nullptr;
  std::vector<std::string> environment_;
};

}  // namespace cwm::fault
