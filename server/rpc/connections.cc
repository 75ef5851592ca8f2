#include "server/rpc/connections.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <utility>

namespace cwm::server {
namespace {

// Numbers below are left to all other descriptors.
constexpr std::int64_t kFirstNumber = 1'024;
// chosen: the kernel's descriptor table is as long as the highest number, half a mebibyte for
// these. A number is reused only after so many connections.
constexpr std::int64_t kMaxNumbers = 65'536;
// measured: checking 4,096 descriptors takes a millisecond, so not every connection of a burst may
// cause a sweep.
constexpr auto kMinSweepPeriod = std::chrono::milliseconds(20);

std::int64_t FirstNumber(std::int64_t max_descriptors) {
  return std::min(kFirstNumber, max_descriptors / 2);
}

}  // namespace

ConnectionLimits ConnectionLimits::Fit(const TransportLimits& limits,
                                       std::int64_t max_descriptors) {
  ConnectionLimits fitted;
  fitted.all = std::min(limits.max_connections, std::max<std::int64_t>(max_descriptors / 2, 1));
  fitted.of_user =
      std::min(limits.max_connections_of_user, std::max<std::int64_t>(fitted.all / 2, 1));
  fitted.silent_of_user =
      std::min(limits.max_silent_connections, std::max<std::int64_t>(fitted.of_user / 2, 1));
  return fitted;
}

std::int64_t MaxDescriptors() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return kFirstNumber;
  constexpr rlim_t kMax = 1 << 30;  // more than Linux allows
  return static_cast<std::int64_t>(std::min(limit.rlim_cur, kMax));
}

Connections::Connections(ConnectionLimits limits, std::int64_t max_descriptors)
    : limits_(limits),
      first_number_(static_cast<int>(FirstNumber(max_descriptors))),
      end_number_(static_cast<int>(std::min(max_descriptors, first_number_ + kMaxNumbers))),
      next_number_(first_number_) {}

bool Connections::HasRoom(User user) const {
  if (open_ >= limits_.all) return false;
  const auto of_user = open_of_.find(user);
  return of_user == open_of_.end() || of_user->second < limits_.of_user;
}

void Connections::Count(User user) {
  ++open_;
  ++open_of_[user];
}

void Connections::Uncount(User user) {
  --open_;
  const auto of_user = open_of_.find(user);
  if (--of_user->second == 0) open_of_.erase(of_user);
}

bool Connections::TryAdmit(User user) {
  const std::lock_guard lock(mutex_);
  if (!HasRoom(user)) {
    if (Clock::now() - last_sweep_ < kMinSweepPeriod) return false;
    DropClosedLocked();
    if (!HasRoom(user)) return false;
  }
  Count(user);
  return true;
}

void Connections::AdmitAlways(User user) {
  const std::lock_guard lock(mutex_);
  Count(user);
}

void Connections::CancelAdmission(User user) {
  const std::lock_guard lock(mutex_);
  Uncount(user);
}

int Connections::MoveToFreshNumber(FileDescriptor connection) {
  for (const bool is_retry : {false, true}) {
    if (is_retry || next_number_ >= end_number_) next_number_ = first_number_;
    const int number = fcntl(connection.number(), F_DUPFD_CLOEXEC, next_number_);
    if (number < 0) continue;
    next_number_ = number + 1;
    return number;
  }
  return connection.Release();  // a recently used number is better than none
}

int Connections::Register(FileDescriptor connection, User user) {
  const std::lock_guard lock(mutex_);
  const int number = MoveToFreshNumber(std::move(connection));
  struct stat info {};
  fstat(number, &info);
  if (const auto former = entries_.find(number); former != entries_.end()) {
    Uncount(former->second.client.uid);
  }
  entries_[number] = {.client = {.connection = ++last_connection_, .uid = user},
                      .device = info.st_dev,
                      .inode = info.st_ino};
  return number;
}

ClientId Connections::Find(int number) const {
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(number);
  if (entry == entries_.end()) return {.connection = ClientId::kClosed, .uid = std::nullopt};
  return entry->second.client;
}

bool Connections::IsOpen(int number, const Entry& entry) {
  struct stat info {};
  return fstat(number, &info) == 0 && info.st_dev == entry.device && info.st_ino == entry.inode;
}

void Connections::DropClosedLocked() {
  last_sweep_ = Clock::now();
  std::erase_if(entries_, [this](const auto& known) {
    const auto& [number, entry] = known;
    if (IsOpen(number, entry)) return false;
    Uncount(entry.client.uid);
    return true;
  });
}

void Connections::DropClosed() {
  const std::lock_guard lock(mutex_);
  DropClosedLocked();
}

void Connections::ShutDown(int how) const {
  const std::lock_guard lock(mutex_);
  for (const auto& [number, entry] : entries_) {
    if (IsOpen(number, entry)) shutdown(number, how);
  }
}

std::int64_t Connections::open() const {
  const std::lock_guard lock(mutex_);
  return open_;
}

}  // namespace cwm::server
