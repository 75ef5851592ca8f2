// The clients of the overload: one that asks small questions, well-behaved ones with batches and
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

// Threads that go round until they are told to end.
class Clients {
 public:
  Clients() = default;
  ~Clients() { End(); }
  Clients(const Clients&) = delete;
  Clients& operator=(const Clients&) = delete;

  // Calls `once` again and again in a thread of its own.
  void Add(std::function<void()> once);
  // Ends what is under way as well.
  void End();
  const std::atomic<bool>& over() const { return over_; }

 private:
  std::atomic<bool> over_ = false;
  std::vector<std::thread> threads_;
};

// What calls of one kind came to. Thread safe.
struct Tally {
  std::mutex mutex;
  std::vector<double> latencies_s;  // of those answered OK
  int refused = 0;                  // with RetryInfo
  int failed = 0;                   // otherwise
  std::string failure;              // the first
  // Of calls that were refused at first and taken later, when they were sent again after the delay
  // that was advised each time: that of the first refusal, and the time from there to the call that
  // was taken.
  std::vector<double> advised_s, actual_s;
};

// Makes the call, again after each refusal with the delay that it advises, until it is answered,
// has failed or taken 30 s; tells the tally. What is `over` meanwhile is not told.
void CallPolitely(const std::shared_ptr<grpc::Channel>& channel, const CallPlan& plan,
                  const std::atomic<bool>& over, Tally& tally);

// Clients with batches of questions, clients with scans. What they ask of is there:
// PrepareOverload.
inline constexpr int kBatchRows = 10'000;
void AddBatchClients(const MeasuredServer& server, Tally& tally, Clients& clients);
void AddScanClients(const MeasuredServer& server, Tally& tally, Clients& clients);
// Clients that send hostile requests of the table, each held for at most half a second.
void AddHostileClients(MeasuredServer& server, std::atomic<int>& sent, Clients& clients);
// A small question every five milliseconds over a connection of its own.
void AddSmallClient(const MeasuredServer& server, Tally& tally, Clients& clients);

CallPlan BatchPlan();
bool PrepareOverload(MeasuredServer& server);

}  // namespace cwm::benchmarks
