// cwm-server: the application behind gRPC, until a signal ends it.
#include <spdlog/async.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "absl/synchronization/mutex.h"
#include "perception/interpret_scene.h"
#include "proto/transfer/default_address.h"
#include "server/core/heap_memory.h"
#include "server/options.h"
#include "server/rpc/connections.h"
#include "server/rpc/server.h"
#include "server/service_manager.h"
#include "server/watchdog.h"
#include "server/web/viewer_server.h"

namespace {

// Within the 10 s that a stop may take, with room for freeing memory.
constexpr auto kGrace = std::chrono::seconds(8);
// What has not ended so long after the grace does not end any more.
constexpr auto kPatience = std::chrono::seconds(1);
constexpr int kStuckExitCode = 3;
// Below, a crowd that fits into one machine fills the table.
constexpr std::int64_t kFewDescriptors = 4'096;

// Blocks the signals that end the server, in this thread and in all that it will start.
sigset_t BlockEndingSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  return signals;
}

// Debian builds Abseil with its debug checks: each lock of gRPC's enters a graph of the order in
// which locks are taken, and what looks like a cycle there ends the process.
void TakeLocksUnwatched() { absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore); }

// A thread of its own writes: whoever does not read our stderr holds no call up. The thread begins
// with the signals blocked, as all others.
void LogToStderr(const std::string& level) {
  constexpr std::size_t kLinesAtOnce = 1'024;  // the oldest go when more wait to be written
  spdlog::init_thread_pool(kLinesAtOnce, 1);
  spdlog::set_default_logger(std::make_shared<spdlog::async_logger>(
      "cwm-server", std::make_shared<spdlog::sinks::stderr_color_sink_mt>(), spdlog::thread_pool(),
      spdlog::async_overflow_policy::overrun_oldest));
  spdlog::set_level(spdlog::level::from_str(level));
}

// Each connection takes one; the soft limit of 1,024 is for programs that use select(2).
void RaiseDescriptorLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  if (limit.rlim_cur < limit.rlim_max) {
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_NOFILE, &limit);
  }
  const std::int64_t count = cwm::server::MaxDescriptors();
  if (count >= kFewDescriptors) return;
  spdlog::warn(
      "the process may have {} file descriptors (ulimit -Hn) and takes at most {} connections",
      count, count / 2);
}

// The last resort: a stop that something holds up ends here.
void EndProcessAfter(std::chrono::milliseconds time) {
  std::thread([time] {
    std::this_thread::sleep_for(time);
    spdlog::error("not stopped after {} ms: ending the process with work under way", time.count());
    spdlog::default_logger()->flush();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));  // the log has a thread of its own
    _exit(kStuckExitCode);
  }).detach();
}

// nullptr where no service manager waits for it.
std::unique_ptr<cwm::server::Watchdog> StartWatchdog(const cwm::server::Server& server) {
  const auto time = cwm::server::WatchdogTime();
  if (!time) return nullptr;
  constexpr int kChecks = 3;  // within the time: one may fail
  return std::make_unique<cwm::server::Watchdog>(
      std::chrono::duration_cast<std::chrono::milliseconds>(*time / kChecks),
      [&server](std::chrono::milliseconds timeout) { return server.CheckItself(timeout); },
      [] { cwm::server::NotifyServiceManager("WATCHDOG=1"); });
}

std::string Joined(const std::vector<std::string>& addresses) {
  std::string text;
  for (const std::string& address : addresses) text += (text.empty() ? "" : ", ") + address;
  return text;
}

using cwm::server::ViewerServer;

// nullptr: none. A default address that cannot be had is no reason not to serve; one that was asked
// for is.
absl::StatusOr<std::unique_ptr<ViewerServer>> StartViewer(
    const std::optional<cwm::server::Options::Viewer>& asked, const cwm::server::Server& server) {
  if (!asked) return nullptr;
  auto viewer = ViewerServer::Start(
      {.address = asked->address, .token = asked->token, .files = cwm::server::BundledPage()},
      server.InProcessChannel());
  if (viewer.ok() || !asked->is_default || absl::IsInvalidArgument(viewer.status())) return viewer;
  spdlog::warn("{}; going on without a viewer, --viewer HOST:PORT gives it another address",
               std::string(viewer.status().message()));
  return nullptr;
}

// The addresses that were given, else the default one.
absl::StatusOr<cwm::server::ListenOptions> ChooseAddresses(cwm::server::ListenOptions listen) {
  if (!listen.addresses.empty()) return listen;
  if (auto status = cwm::PrepareDefaultAddress(); !status.ok()) return status;
  listen.addresses.push_back(cwm::DefaultAddress());
  return listen;
}

int Run(const cwm::server::Options& options, const sigset_t& signals) {
  constexpr int kUnavailableExitCode = 2;
  RaiseDescriptorLimit();
  cwm::server::Application application{.limits = {.max_memory_bytes = options.memory_limit_bytes},
                                       .retention = {},
                                       .interpret = cwm::perception::InterpretScene};
  const auto listen = ChooseAddresses(options.listen);
  if (!listen.ok()) {
    spdlog::error("{}", std::string(listen.status().message()));
    return kUnavailableExitCode;
  }
  auto server = cwm::server::Server::Start(application, *listen);
  if (!server.ok()) {
    spdlog::error("{}", std::string(server.status().message()));
    return kUnavailableExitCode;
  }
  std::fprintf(stderr, "cwm-server %s listens on %s\n", CWM_VERSION,
               Joined((*server)->addresses()).c_str());
  auto viewer = StartViewer(options.viewer, **server);
  if (!viewer.ok()) {
    spdlog::error("{}", std::string(viewer.status().message()));
    return kUnavailableExitCode;
  }
  if (*viewer != nullptr) {
    const std::vector<std::string>& urls = (*viewer)->urls();
    std::fprintf(stderr, "cwm-server %s shows the world at %s\n", CWM_VERSION,
                 urls.front().c_str());
    // Of another name or network; each on a line, to be clicked or copied.
    for (auto url = urls.begin() + 1; url != urls.end(); ++url) {
      std::fprintf(stderr, "  or at %s\n", url->c_str());
    }
  }
  cwm::server::NotifyServiceManager("READY=1");
  auto watchdog = StartWatchdog(**server);
  int signal = 0;
  sigwait(&signals, &signal);
  EndProcessAfter(kGrace + kPatience);
  cwm::server::NotifyServiceManager("STOPPING=1");
  spdlog::info("draining after signal {}: what is under way is finished", signal);
  watchdog = nullptr;
  if (*viewer != nullptr) (*viewer)->Stop();
  (*server)->Stop(kGrace);
  spdlog::info("stopped");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const auto parsed = cwm::server::ParseOptions(argc, argv);
  if (!parsed.options) return parsed.exit_code;
  cwm::server::KeepFreedMemory();
  TakeLocksUnwatched();
  const sigset_t signals = BlockEndingSignals();
  LogToStderr(parsed.options->log_level);
  const int exit_code = Run(*parsed.options, signals);
  spdlog::shutdown();  // what was logged is written
  return exit_code;
}
