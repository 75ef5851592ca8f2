// The clients of a history: writers, a reader, watchers. They live longer than a server: what was
// not answered is sent again to the next one, and watches resume.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tests/fault/calls.h"

namespace cwm::fault {

struct WorkloadOptions {
  std::uint32_t seed = 1;
  int writers = 3;         // of the world "main"
  bool has_worlds = true;  // one more client creates and deletes worlds
  // Of one client, which sets the state of the robot and nothing else; a power cut may take that.
  bool has_states = true;
  std::chrono::milliseconds deadline = std::chrono::seconds(10);  // of a call
  std::chrono::microseconds pause =
      std::chrono::microseconds(500);  // of each client, between calls
};

class Workload {
 public:
  // The client that looks at the server after each restart.
  static constexpr int kInspector = 0;
  static constexpr char kMain[] = "main";

  explicit Workload(const WorkloadOptions& options);
  ~Workload();

  // Creates the world "main" and its robot, through an inspector's connection. False if the server
  // does not answer.
  bool Prepare(const std::string& address);
  // Starts the clients on a server that is ready. They end when the connection is lost.
  void Start(const std::string& address);
  // Ends the clients and waits for them.
  void Stop();
  // Ends the writers and the reader once everything is answered, then the watchers once they have
  // seen the newest revision. False if that takes too long.
  bool Finish(std::chrono::milliseconds patience);

  // Puts so many meshes of 60 KB, which the store keeps inside its records, under few names. False
  // if one is not answered.
  bool PutMeshes(const std::string& address, int count);
  // Records that the wall clock of the next server is ahead of all that is kept for some time.
  void SetClockAhead();

  // Reads all live worlds, and with a watch everything since the last inspection. `whole`: with a
  // watch everything since revision 0, and the files of other tools. Returns an empty text if all
  // went well.
  std::string Inspect(const std::string& address, bool whole, bool after_restart);
  // The next inspection watches from the beginning: for what was lost in a power cut.
  void ForgetInspected() { inspected_ = 0; }

  Recorder& recorder() { return recorder_; }
  // Answers so far. From any thread.
  struct Counts {
    std::int64_t written = 0;
    std::int64_t full = 0;  // refused with DISK_FULL
    std::int64_t reads = 0;
  };
  Counts counts() const { return {.written = written_, .full = full_, .reads = reads_}; }

 private:
  struct Client;
  struct Watcher;

  void RunWriter(Client& client, const std::string& address);
  void RunWorlds(Client& client, const std::string& address);
  void RunStates(Client& client, const std::string& address);
  void RunReader(Client& client, const std::string& address);
  void RunWatcher(Watcher& watcher, const std::string& address);
  struct Answer {
    bool is_lost = false;                     // the connection
    std::optional<Operation> operation = {};  // empty: it is to be sent again
  };
  bool GoesOn(const Client& client) const;
  // Sends what is pending, or `make()`.
  template <class Make>
  Answer Step(Client& client, const client::Connection& connection, const Make& make);
  Operation MakeWrite(Client& client, const client::Connection& connection);
  Change MakeChange(Client& client, const client::Connection& connection);
  Operation MakeRobotWrite(Client& client) const;
  Operation MakeWorldWrite(Client& client) const;
  Operation NewOperation(Client& client, const std::string& world, const std::string& uid) const;
  std::string InspectMain(const client::Connection& connection, bool whole, bool after_restart);
  void Note(const Operation& operation);

  WorkloadOptions options_;
  Recorder recorder_;
  std::string main_uid_;
  std::vector<std::unique_ptr<Client>> clients_;
  std::vector<std::unique_ptr<Watcher>> watchers_;
  std::vector<std::thread> threads_;
  std::vector<std::thread> watch_threads_;
  std::atomic<bool> stopping_ = false;    // writers and readers end, with or without answers
  std::atomic<bool> finishing_ = false;   // writers end once everything is answered
  std::atomic<std::int64_t> newest_ = 0;  // revision of "main" that was acknowledged
  std::atomic<std::int64_t> written_ = 0;
  std::atomic<std::int64_t> full_ = 0;
  std::atomic<std::int64_t> reads_ = 0;
  std::int64_t inspected_ = 0;  // of "main"
  std::mutex live_mutex_;
  std::map<std::string, std::string> live_;  // other worlds: their uids by their names
};

}  // namespace cwm::fault
