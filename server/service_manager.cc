#include "server/service_manager.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "absl/strings/numbers.h"
#include "server/core/file_descriptor.h"

namespace cwm::server {

bool NotifyServiceManager(const std::string& state) {
  const char* const named = std::getenv("NOTIFY_SOCKET");
  if (named == nullptr) return false;
  const std::string_view name = named;
  sockaddr_un address{};
  if (name.size() < 2 || name.size() >= sizeof(address.sun_path)) return false;
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, name.data(), name.size());
  if (name.front() == '@') address.sun_path[0] = '\0';  // abstract namespace
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
  const FileDescriptor fd(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!fd.is_open()) return false;
  return sendto(fd.number(), state.data(), state.size(), MSG_NOSIGNAL,
                reinterpret_cast<const sockaddr*>(&address),
                size) == static_cast<ssize_t>(state.size());
}

std::optional<std::chrono::microseconds> WatchdogTime() {
  const char* const time = std::getenv("WATCHDOG_USEC");
  std::int64_t time_us = 0;
  if (time == nullptr || !absl::SimpleAtoi(time, &time_us) || time_us <= 0) return std::nullopt;
  const char* const process = std::getenv("WATCHDOG_PID");
  std::int64_t pid = 0;
  if (process != nullptr && (!absl::SimpleAtoi(process, &pid) || pid != getpid())) {
    return std::nullopt;
  }
  return std::chrono::microseconds(time_us);
}

}  // namespace cwm::server
