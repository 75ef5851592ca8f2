// A cwm-server on a store, which can be killed and started again.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/cpp/connection.h"
#include "tests/support/process.h"

namespace cwm::fault {

struct ServerOptions {
  std::string program = {};                   // the path of cwm-server
  std::string store = {};                     // a directory; empty: worlds are in memory
  std::string directory = {};                 // of its socket and its log
  std::vector<std::string> environment = {};  // NAME=VALUE
  std::vector<std::string> arguments = {};
};

class ServerProcess {
 public:
  // Starts the server. Call it from the main thread alone: the server is killed with the thread
  // that started it, so that no server outlives an interrupted run.
  explicit ServerProcess(const ServerOptions& options);

  // True when it answers; false if it ended or did not answer in time.
  bool WaitUntilReady(std::chrono::milliseconds patience);
  bool Running() const { return process_->Running(); }
  // SIGKILL, and waits for the end.
  void Kill();
  // SIGTERM; the exit code.
  int Stop() { return process_->Stop(); }
  // Waits for it to end by itself. The exit code; -1 if a signal ended it; empty if it did not end.
  std::optional<int> WaitForEnd(std::chrono::milliseconds patience);
  void Signal(int signal) const { process_->Signal(signal); }

  std::string address() const { return "unix:" + options_.directory + "/cwm.sock"; }
  // What this server, and those before it in the directory, wrote on stderr.
  std::string Log() const;
  // The last lines of it.
  std::string LogTail() const;

 private:
  ServerOptions options_;
  std::unique_ptr<testing::BackgroundProcess> process_;
};

}  // namespace cwm::fault
