#include "tests/fault/fault_switch.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace cwm::fault {

FaultSwitch::FaultSwitch(const std::string& file, const std::string& directory)
    : environment_({"LD_PRELOAD=" CWM_DISK_FAULTS_LIBRARY, "CWM_DISK_FAULTS=" + file,
                    "CWM_DISK_PATH=" + directory}) {
  const int fd = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  const bool has_size = fd >= 0 && ftruncate(fd, sizeof(DiskFaults)) == 0;
  void* const bytes =
      has_size ? mmap(nullptr, sizeof(DiskFaults), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0)
               : MAP_FAILED;
  const int error = errno;
  if (fd >= 0) close(fd);
  if (bytes == MAP_FAILED) throw std::system_error(error, std::generic_category(), file);
  faults_ = static_cast<DiskFaults*>(bytes);  // zeros: no fault
}

FaultSwitch::~FaultSwitch() { munmap(faults_, sizeof(DiskFaults)); }

void FaultSwitch::Set(DiskFault fault, std::int64_t calls_before) {
  faults_->fault = DiskFault::kNone;
  faults_->calls_before = calls_before;
  faults_->hits = 0;
  faults_->fault = fault;
}

}  // namespace cwm::fault
