// A cwm-server that is measured from outside: its memory and the processor time of its threads, as
// the kernel reports them.
#pragma once

#include <grpcpp/channel.h>
#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/cpp/connection.h"
#include "tests/support/process.h"

namespace cwm::benchmarks {

using SteadyClock = std::chrono::steady_clock;

inline double SecondsSince(SteadyClock::time_point start) {
  return std::chrono::duration<double>(SteadyClock::now() - start).count();
}

inline constexpr double kMebi = 1 << 20;

// The cwm-server beside this program, or the one set by UseServerProgram.
std::string ServerProgram();
void UseServerProgram(std::string path);

struct MeasuredServerOptions {
  std::string program = ServerProgram();
  int max_descriptors = 0;  // soft and hard limit; 0: those of this process
  int cores = 0;            // that its threads may use; 0: those of this process
  bool listens_on_tcp = false;
  std::vector<std::string> arguments = {};  // further ones of the server
};

class MeasuredServer {
 public:
  explicit MeasuredServer(const MeasuredServerOptions& options = {});
  // Kills the server; call Stop_s before to see it stop.
  ~MeasuredServer();
  MeasuredServer(const MeasuredServer&) = delete;
  MeasuredServer& operator=(const MeasuredServer&) = delete;

  bool up() const { return up_; }
  bool running() const { return process_.Running(); }
  pid_t pid() const { return process_.pid(); }
  const client::Connection& connection() const { return *connection_; }
  const std::string& socket_path() const { return socket_path_; }
  // 0 if it does not listen on TCP.
  int tcp_port() const { return tcp_port_; }
  // A channel whose calls share no socket with others and have no limit on received messages.
  std::shared_ptr<grpc::Channel> NewChannel() const;

  // Resident anonymous memory: mapped files and libraries do not count. 0 if the server is gone.
  std::int64_t ResidentBytes() const;
  // Processor time of all threads, including those that have ended; 0 if the server is gone.
  double Cpu_s() const;
  // The processor time of each live thread.
  std::map<pid_t, double> ThreadCpu_s() const;
  // True if a thread is running or waits for a core, which happens on a shared machine.
  bool HasRunnableThread() const;
  // Waits until the server has been nearly idle for 100 ms, with no runnable thread. False if it
  // has used `cpu_limit_s` of processor time meanwhile, after three times as long (on a shared
  // machine it waits for cores), or if it is gone.
  bool WaitUntilIdle(double cpu_limit_s) const;

  // Seconds from SIGTERM to its end; empty if it does not end within `limit_s`.
  std::optional<double> Stop_s(double limit_s);

 private:
  testing::ScratchDirectory scratch_;
  std::string socket_path_;
  int tcp_port_ = 0;
  testing::BackgroundProcess process_;
  std::unique_ptr<client::Connection> connection_;
  bool up_ = false;
};

// A TCP port of loopback that nobody listens on.
int FreePort();

}  // namespace cwm::benchmarks
