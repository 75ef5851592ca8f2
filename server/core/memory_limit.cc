#include "server/core/memory_limit.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

#include "absl/strings/numbers.h"

namespace cwm::server {
namespace {

constexpr std::int64_t kUnlimited = std::numeric_limits<std::int64_t>::max();

// Unlimited if the file is missing or has "max"; version 1 writes a number beyond any machine.
std::int64_t LimitIn(const std::string& path) {
  std::ifstream file(path);
  std::string text;
  std::int64_t bytes = 0;
  if (!(file >> text) || !absl::SimpleAtoi(text, &bytes) || bytes <= 0) return kUnlimited;
  return bytes;
}

// The smallest limit of a group and of all groups that contain it.
std::int64_t LimitOfGroup(const std::string& root, std::string group, const char* file) {
  std::int64_t smallest = kUnlimited;
  for (;;) {
    smallest = std::min(smallest, LimitIn(root + group + "/" + file));
    if (group.empty()) return smallest;
    group.resize(group.rfind('/'));
  }
}

// The smallest memory limit of the process's control groups. Lines of /proc/self/cgroup are
// "number:controllers:/path"; version 2 has no controllers.
std::int64_t ControlGroupLimit() {
  std::ifstream groups("/proc/self/cgroup");
  std::int64_t smallest = kUnlimited;
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    std::string path = line.substr(second + 1);
    if (path == "/") path.clear();
    if (!path.empty() && path.front() != '/') continue;
    if (controllers == ",,") {
      smallest = std::min(smallest, LimitOfGroup("/sys/fs/cgroup", path, "memory.max"));
    } else if (controllers.find(",memory,") != std::string::npos) {
      smallest =
          std::min(smallest, LimitOfGroup("/sys/fs/cgroup/memory", path, "memory.limit_in_bytes"));
    }
  }
  return smallest;
}

std::int64_t AddressSpaceLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kUnlimited;
  return static_cast<std::int64_t>(
      std::min<rlim_t>(limit.rlim_cur, static_cast<rlim_t>(kUnlimited)));
}

}  // namespace

std::int64_t AvailableMemory() {
  const std::int64_t machine = static_cast<std::int64_t>(sysconf(_SC_PHYS_PAGES)) *
                               static_cast<std::int64_t>(sysconf(_SC_PAGESIZE));
  return std::min({machine, ControlGroupLimit(), AddressSpaceLimit()});
}

std::int64_t DefaultMemoryLimit() {
  static const std::int64_t kLimit = AvailableMemory() / 4 * 3;
  return kLimit;
}

}  // namespace cwm::server
