// cwm-server: serves the application over gRPC until a signal ends it.
#include <spdlog/async.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "absl/synchronization/mutex.h"
#include "perception/interpret_scene.h"
#include "proto/transfer/default_address.h"
#include "server/core/heap_memory.h"
#include "server/durable_worlds.h"
#include "server/options.h"
#include "server/rpc/connections.h"
#include "server/rpc/server.h"
#include "server/service_manager.h"
#include "server/watchdog.h"
#include "server/web/viewer_server.h"

namespace {

// Shorter than the 10 s that a stop may take, leaving time to free memory.
constexpr auto kGrace = std::chrono::seconds(8);
// After the grace period and this time the process is ended, whatever is still running.
constexpr auto kPatience = std::chrono::seconds(1);
constexpr int kStuckExitCode = 3;
constexpr auto kTimeToLog = std::chrono::milliseconds(50);  // lets the log's thread write
// With fewer file descriptors than this, the clients of a single machine can use all of them.
constexpr std::int64_t kFewDescriptors = 4'096;

// Blocks the signals that end the server, in this thread and in all threads started later.
sigset_t BlockTerminationSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  return signals;
}

// Switches Abseil's deadlock detection off. Debian builds Abseil with its debug checks: each lock
// of gRPC is entered into a graph of lock orders, and an apparent cycle there aborts the process.
void DisableDeadlockDetection() {
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
}

// Logs from a thread of its own, so that nobody who fails to read our stderr delays a call. That
// thread inherits the blocked signals.
void LogToStderr(const std::string& level) {
  constexpr std::size_t kLinesAtOnce = 1'024;  // if more lines wait, the oldest are dropped
  spdlog::init_thread_pool(kLinesAtOnce, 1);
  spdlog::set_default_logger(std::make_shared<spdlog::async_logger>(
      "cwm-server", std::make_shared<spdlog::sinks::stderr_color_sink_mt>(), spdlog::thread_pool(),
      spdlog::async_overflow_policy::overrun_oldest));
  spdlog::set_level(spdlog::level::from_str(level));
}

// Each connection needs a descriptor; the soft limit of 1,024 exists for programs that use
// select(2).
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

// The last resort: ends the process if the orderly stop takes longer than `time`.
void EndProcessAfter(std::chrono::milliseconds time) {
  std::thread([time] {
    std::this_thread::sleep_for(time);
    spdlog::error("not stopped after {} ms: ending the process with work under way", time.count());
    spdlog::default_logger()->flush();
    std::this_thread::sleep_for(kTimeToLog);
    _exit(kStuckExitCode);
  }).detach();
}

// nullptr if no service manager expects notifications.
std::unique_ptr<cwm::server::Watchdog> StartWatchdog(const cwm::server::Server& server) {
  const auto time = cwm::server::WatchdogTime();
  if (!time) return nullptr;
  constexpr int kChecks = 3;  // per watchdog time, so that one may fail
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

// nullptr if there is no viewer. An unavailable default address does not keep the server from
// starting; an unavailable address that was asked for does.
absl::StatusOr<std::unique_ptr<ViewerServer>> StartViewer(
    const std::optional<cwm::server::Options::Viewer>& options, const cwm::server::Server& server) {
  if (!options) return nullptr;
  auto viewer = ViewerServer::Start(
      {.address = options->address, .token = options->token, .files = cwm::server::BundledPage()},
      server.InProcessChannel());
  if (viewer.ok() || !options->is_default || absl::IsInvalidArgument(viewer.status()))
    return viewer;
  spdlog::warn("{}; going on without a viewer, --viewer HOST:PORT gives it another address",
               std::string(viewer.status().message()));
  return nullptr;
}

// The addresses that were given, or the default address.
absl::StatusOr<cwm::server::ListenOptions> ChooseAddresses(cwm::server::ListenOptions listen) {
  if (!listen.addresses.empty()) return listen;
  if (auto status = cwm::PrepareDefaultAddress(); !status.ok()) return status;
  listen.addresses.push_back(cwm::DefaultAddress());
  return listen;
}

using cwm::server::DurableWorlds;

// nullptr if worlds are kept in memory. Tells people which it is.
absl::StatusOr<std::unique_ptr<DurableWorlds>> OpenStore(
    const cwm::server::Options::Store& options) {
  if (options.directory.empty()) {
    std::fprintf(stderr,
                 "cwm-server %s keeps worlds in memory, until it ends (--store sqlite:PATH keeps "
                 "them)\n",
                 CWM_VERSION);
    return nullptr;
  }
  auto opened = DurableWorlds::Open(options);
  if (opened.ok()) {
    std::fprintf(stderr, "cwm-server %s keeps worlds in %s\n", CWM_VERSION,
                 (*opened)->location().c_str());
  }
  return opened;
}

int Run(const cwm::server::Options& options, const sigset_t& signals) {
  constexpr int kUnavailableExitCode = 2;
  RaiseDescriptorLimit();
  const auto durable = OpenStore(options.store);  // outlives the application's worlds
  if (!durable.ok()) {
    spdlog::error("{}", std::string(durable.status().message()));
    return kUnavailableExitCode;
  }
  cwm::server::Application application{.limits = {.max_memory_bytes = options.memory_limit_bytes},
                                       .retention = {},
                                       .interpret = cwm::perception::InterpretScene};
  if (*durable != nullptr) {
    application.store = (*durable)->location();
    application.gate.Close();
  }
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
    // The addresses for other host names or networks, one per line so that they can be clicked or
    // copied.
    for (auto url = urls.begin() + 1; url != urls.end(); ++url) {
      std::fprintf(stderr, "  or at %s\n", url->c_str());
    }
  }
  if (*durable != nullptr) {
    const auto restored = (*durable)->Restore(application, signals);
    if (!restored) {
      spdlog::info("ending before the worlds were restored");
      (*server)->Stop(std::chrono::milliseconds(0));
      spdlog::default_logger()->flush();
      std::this_thread::sleep_for(kTimeToLog);
      _exit(0);
    }
    if (!restored->ok()) {
      spdlog::error("{}", std::string(restored->message()));
      return kUnavailableExitCode;
    }
    (*server)->OpenGate();
    cwm::server::NotifyServiceManager("STATUS=serving");
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
  if (*durable != nullptr) {
    if (const absl::Status closed = (*durable)->Close(application); !closed.ok()) {
      spdlog::error("the store was not closed: {}", std::string(closed.message()));
      return cwm::server::kStoreFailedExitCode;
    }
  }
  spdlog::info("stopped");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const auto parsed = cwm::server::ParseOptions(argc, argv);
  if (!parsed.options) return parsed.exit_code;
  cwm::server::KeepFreedMemory();
  DisableDeadlockDetection();
  const sigset_t signals = BlockTerminationSignals();
  LogToStderr(parsed.options->log_level);
  const int exit_code = Run(*parsed.options, signals);
  spdlog::shutdown();  // writes the pending log lines
  return exit_code;
}
