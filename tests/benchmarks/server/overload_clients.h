// The clients of the overload: one that sends small queries, well-behaved ones with batches and
// scans, and hostile ones.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/benchmarks/server/held_call.h"
#include "tests/benchmarks/server/measured_server.h"

namespace cwm::benchmarks {

// Threads that loop until they are told to end.
class Clients {
 public:
  Clients() = default;
  ~Clients() { End(); }
  Clients(const Clients&) = delete;
  Clients& operator=(const Clients&) = delete;

  // Calls `once` again and again in a thread of its own.
  void Add(std::function<void()> once);
  // Ends the threads, after their present calls.
  void End();
  const std::atomic<bool>& over() const { return over_; }

 private:
  std::atomic<bool> over_ = false;
  std::vector<std::thread> threads_;
};

// The outcomes of calls of one kind. Thread safe.
struct Tally {
  std::mutex mutex;
  std::vector<double> latencies_s;  // of those answered OK
  int refused = 0;                  // with RetryInfo
  int failed = 0;                   // otherwise
  std::string failure;              // the first
  // For calls that were refused first and accepted later, after waiting for the advised delay each
  // time: the delay advised with the first refusal, and the time from there to the accepted call.
  std::vector<double> advised_s, actual_s;
};

// Makes the call, and repeats it after each refusal with the advised delay, until it is answered,
// has failed or has taken 30 s; adds it to the tally, unless `over` was set meanwhile.
void CallWithRetry(const std::shared_ptr<grpc::Channel>& channel, const CallPlan& plan,
                   const std::atomic<bool>& over, Tally& tally);

// Clients with batches of queries, and clients with scans. PrepareOverload puts what they query
// into place.
inline constexpr int kBatchRows = 10'000;
void AddBatchClients(const MeasuredServer& server, Tally& tally, Clients& clients);
void AddScanClients(const MeasuredServer& server, Tally& tally, Clients& clients);
// Clients that send hostile requests of the table, each held for at most half a second.
void AddHostileClients(MeasuredServer& server, std::atomic<int>& sent, Clients& clients);
// A client that sends a small query every five milliseconds over a connection of its own.
void AddSmallClient(const MeasuredServer& server, Tally& tally, Clients& clients);

CallPlan BatchPlan();
bool PrepareOverload(MeasuredServer& server);

}  // namespace cwm::benchmarks
