#include "tests/fault/loop_disk.h"

#include <fcntl.h>
#include <linux/fs.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

namespace cwm::fault {
namespace {

// EXT4_IOC_SHUTDOWN and its mode NOLOGFLUSH, of the kernel's fs/ext4/ext4.h.
constexpr unsigned long kShutdown = _IOR('X', 125, std::uint32_t);
constexpr std::uint32_t kWithoutLogFlush = 2;

absl::Status Failed(const std::string& what, const std::string& why) {
  return absl::UnavailableError(what + ": " + why);
}

absl::Status Run(const std::vector<std::string>& command) {
  const testing::ProcessResult result = testing::RunProgram(command);
  return result.exit_code == 0 ? absl::OkStatus() : Failed(command.front(), result.err);
}

}  // namespace

absl::StatusOr<std::unique_ptr<LoopDisk>> LoopDisk::Make(std::int64_t bytes) {
  if (geteuid() != 0) return absl::UnavailableError("loop devices need root");
  static const bool has_namespace =
      unshare(CLONE_NEWNS) == 0 && mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
  if (!has_namespace) return Failed("unshare", std::strerror(errno));
  std::unique_ptr<LoopDisk> disk(new LoopDisk());
  std::ofstream(disk->image_).close();
  std::filesystem::resize_file(disk->image_, static_cast<std::uintmax_t>(bytes));
  std::filesystem::create_directory(disk->path_);
  if (auto status = Run({"mkfs.ext4", "-q", "-F", disk->image_}); !status.ok()) return status;
  if (auto status = disk->Mount(); !status.ok()) return status;
  return disk;
}

LoopDisk::~LoopDisk() { umount2(path_.c_str(), MNT_DETACH); }

absl::Status LoopDisk::Mount() const { return Run({"mount", "-o", "loop", image_, path_}); }

absl::Status LoopDisk::Cut() {
  struct stat disk {};
  struct stat parent {};
  // Never shut down another file system than our own.
  if (stat(path_.c_str(), &disk) != 0 || stat(scratch_.path().c_str(), &parent) != 0 ||
      disk.st_dev == parent.st_dev) {
    return Failed("cut", path_ + " is not mounted");
  }
  const int directory = open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory < 0) return Failed("open", std::strerror(errno));
  std::uint32_t mode = kWithoutLogFlush;
  const bool ok = ioctl(directory, kShutdown, &mode) == 0;
  const int error = errno;
  close(directory);
  return ok ? absl::OkStatus() : Failed("ioctl", std::strerror(error));
}

absl::Status LoopDisk::Remount() {
  // The kernel may hold files of a killed process for a moment.
  constexpr int kTries = 200;
  int tries = 0;
  while (umount(path_.c_str()) != 0) {
    if (++tries == kTries) return Failed("umount", std::strerror(errno));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return Mount();
}

absl::Status LoopDisk::Fill() {
  const int file = open((path_ + "/filler").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0) return Failed("open", std::strerror(errno));
  off_t size = 0;
  for (off_t step = off_t{1} << 20; step >= 4'096; step /= 2) {
    while (posix_fallocate(file, size, step) == 0) size += step;
  }
  close(file);
  return absl::OkStatus();
}

void LoopDisk::Empty() { unlink((path_ + "/filler").c_str()); }

}  // namespace cwm::fault
