// A full descriptor table, and whether the server accepts connections afterwards.
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "tests/benchmarks/server/measured_server.h"
#include "tests/benchmarks/server/raw_http2.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

constexpr int kDescriptors = 1'024;
constexpr int kConnections = 1'100;

// Raises the descriptor limit of this process, which holds the other ends, and restores it, so that
// the servers of other figures start with the original limits.
class RaisedLimit {
 public:
  RaisedLimit() {
    getrlimit(RLIMIT_NOFILE, &before_);
    rlimit raised = before_;
    raised.rlim_cur = raised.rlim_max;
    setrlimit(RLIMIT_NOFILE, &raised);
  }
  ~RaisedLimit() { setrlimit(RLIMIT_NOFILE, &before_); }
  RaisedLimit(const RaisedLimit&) = delete;
  RaisedLimit& operator=(const RaisedLimit&) = delete;

 private:
  rlimit before_{};
};

// True if a new connection is made and its call answered within five seconds.
bool Answers(const std::string& address) {
  constexpr auto kLimit = std::chrono::seconds(5);
  const client::Connection connection({.address = address, .deadline = kLimit});
  if (!connection.channel()->WaitForConnected(std::chrono::system_clock::now() + kLimit)) {
    return false;
  }
  return connection
      .Call(&v1::AdminService::Stub::GetServerInfo, connection.admin(), v1::GetServerInfoRequest())
      .ok();
}

// Opens the connections, waits, closes them and waits; returns how many there were.
template <class Connect>
int Flood(const Connect& connect) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  std::vector<int> fds;
  while (static_cast<int>(fds.size()) < kConnections && std::chrono::steady_clock::now() < end) {
    const int fd = connect();
    if (fd >= 0) fds.push_back(fd);
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));
  for (const int fd : fds) close(fd);
  std::this_thread::sleep_for(std::chrono::seconds(1));
  return static_cast<int>(fds.size());
}

}  // namespace

void MeasureListener(Report& report) {
  const RaisedLimit raised;
  int answered = 0;
  for (const bool is_tcp : {false, true}) {
    const char* const kind = is_tcp ? "TCP" : "Unix socket";
    MeasuredServer server({.max_descriptors = kDescriptors, .listens_on_tcp = is_tcp});
    if (!server.up()) return report.Fail("the server did not come up with 1 024 descriptors");
    const std::string address =
        is_tcp ? "127.0.0.1:" + std::to_string(server.tcp_port()) : "unix:" + server.socket_path();
    if (!Answers(address)) return report.Fail(std::string("no answer at first over ") + kind);
    const int count = Flood([&] {
      return is_tcp ? ConnectLoopback(server.tcp_port()) : ConnectUnix(server.socket_path());
    });
    const bool ok = Answers(address);
    answered += ok ? 1 : 0;
    report.Detail(
        std::string("Listener, ") + kind + ": " + std::to_string(count) +
        " idle connections to a server with 1 024 descriptors, closed again; then a call " +
        (ok ? "is answered"
            : (server.running() ? "is not answered within 5 s" : "finds the server dead")));
  }
  report.Add(
      WithLimit({.key = "accept_after_emfile",
                 .value = answered == 2 ? 1.0 : 0.0,
                 .unit = "1",
                 .how = "1: a call is answered over a Unix socket and over TCP after 1 100 idle "
                        "connections to a server with 1 024 descriptors were closed"},
                1, "limit, at least"));
}

}  // namespace cwm::benchmarks
