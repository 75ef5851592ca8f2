#include "tests/fault/server_process.h"

#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>

namespace cwm::fault {
namespace {

std::vector<std::string> CommandOf(const ServerOptions& options) {
  std::vector<std::string> command = {"setpriv", "--pdeathsig", "KILL", "env",
                                      "XDG_RUNTIME_DIR=" + options.directory};
  command.insert(command.end(), options.environment.begin(), options.environment.end());
  command.insert(command.end(),
                 {options.program, "--listen", "unix:" + options.directory + "/cwm.sock",
                  "--viewer", "off", "--log-level", "warn"});
  if (!options.store.empty()) command.insert(command.end(), {"--store", "sqlite:" + options.store});
  command.insert(command.end(), options.arguments.begin(), options.arguments.end());
  return command;
}

// True if something accepts connections at the path.
bool Accepts(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path)) return false;
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  const bool ok = connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  close(fd);
  return ok;
}

}  // namespace

ServerProcess::ServerProcess(const ServerOptions& options)
    : options_(options),
      process_(std::make_unique<testing::BackgroundProcess>(CommandOf(options),
                                                            options.directory + "/server.log")) {}

bool ServerProcess::WaitUntilReady(std::chrono::milliseconds patience) {
  constexpr auto kPause = std::chrono::milliseconds(4);
  const auto end = std::chrono::steady_clock::now() + patience;
  const std::string path = options_.directory + "/cwm.sock";
  while (!Accepts(path)) {
    if (!Running() || std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(kPause);
  }
  const client::Connection connection(
      {.address = address(), .deadline = std::chrono::milliseconds(2'000)});
  // Refused with UNAVAILABLE while the store is replayed.
  while (
      !connection
           .Call(&v1::WorldService::Stub::ListWorlds, connection.worlds(), v1::ListWorldsRequest())
           .ok()) {
    if (!Running() || std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(kPause);
  }
  return true;
}

void ServerProcess::Kill() {
  process_->Signal(SIGKILL);
  process_->Stop();
}

std::optional<int> ServerProcess::WaitForEnd(std::chrono::milliseconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (Running()) {
    if (std::chrono::steady_clock::now() > end) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return process_->Stop();
}

std::string ServerProcess::Log() const {
  std::ifstream file(options_.directory + "/server.log");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string ServerProcess::LogTail() const {
  constexpr std::size_t kMaxBytes = 1'500;
  const std::string log = Log();
  return log.size() <= kMaxBytes ? log : log.substr(log.size() - kMaxBytes);
}

}  // namespace cwm::fault
