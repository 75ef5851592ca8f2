// The service that well-behaved clients get while others overload the server.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "tests/benchmarks/server/overload_clients.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

constexpr double kOverload_s = 20, kAlone_s = 3;
constexpr double kMaxP99Ratio = 20, kMinGoodput = 0.9, kMaxWait_s = 5;

void Pause(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

// The service that each kind of client gets if there is no other.
struct Alone {
  std::vector<double> small_s;  // latencies
  double batches_per_s = 0, scans_per_s = 0;
};

using AddClients = void (*)(const MeasuredServer&, Tally&, Clients&);

// Answers per second to clients that are alone; waits for at least kMinAnswers of them, within a
// time limit.
double RateAlone(const MeasuredServer& server, AddClients add, std::string* failure) {
  constexpr std::size_t kMinAnswers = 6;
  constexpr double kLimit_s = 15;
  Tally tally;
  Clients clients;
  add(server, tally, clients);
  const auto start = SteadyClock::now();
  std::size_t count = 0;
  double seconds = 0;
  while (seconds < kAlone_s || (count < kMinAnswers && seconds < kLimit_s)) {
    Pause(0.05);
    const std::lock_guard lock(tally.mutex);
    count = tally.latencies_s.size();
    seconds = SecondsSince(start);
    if (tally.failed > 0) *failure = tally.failure;
  }
  clients.End();
  return static_cast<double>(count) / seconds;
}

Alone MeasureAlone(const MeasuredServer& server, std::string* failure) {
  Alone alone;
  {
    Tally tally;
    Clients clients;
    AddSmallClient(server, tally, clients);
    Pause(kAlone_s);
    clients.End();
    alone.small_s = tally.latencies_s;
    if (tally.failed > 0) *failure = tally.failure;
  }
  alone.batches_per_s = RateAlone(server, AddBatchClients, failure);
  alone.scans_per_s = RateAlone(server, AddScanClients, failure);
  server.WaitUntilIdle(5);
  return alone;
}

double LatencyOfOneBatch_s(const MeasuredServer& server) {
  Tally tally;
  const auto channel = server.NewChannel();
  const std::atomic<bool> over = false;
  for (int i = 0; i < 9; ++i) CallWithRetry(channel, BatchPlan(), over, tally);
  return Median(tally.latencies_s);
}

struct Overload {
  Tally small, batch, scan;
  std::atomic<int> hostile = 0;
  double seconds = 0;
  std::size_t batches = 0, scans = 0;  // answered in time
};

void RunOverload(MeasuredServer& server, Overload& overload) {
  Clients clients;
  AddHostileClients(server, overload.hostile, clients);
  AddBatchClients(server, overload.batch, clients);
  AddScanClients(server, overload.scan, clients);
  AddSmallClient(server, overload.small, clients);
  const auto start = SteadyClock::now();
  while (SecondsSince(start) < kOverload_s && server.running()) Pause(0.1);
  overload.seconds = SecondsSince(start);
  {
    const std::lock_guard lock(overload.batch.mutex);
    overload.batches = overload.batch.latencies_s.size();
  }
  {
    const std::lock_guard lock(overload.scan.mutex);
    overload.scans = overload.scan.latencies_s.size();
  }
  clients.End();
}

void PrintTally(const char* name, const Tally& tally, Report& report) {
  char text[400];
  const std::vector<double>& latencies_s = tally.latencies_s;
  std::snprintf(
      text, sizeof(text),
      "  %-7s %6zu answered, p50 %8.2f ms, p99 %8.2f ms, longest %8.2f ms; %d refused with "
      "RetryInfo, %d failed %.120s",
      name, latencies_s.size(), Median(latencies_s) * 1e3, Quantile(latencies_s, 0.99) * 1e3,
      Quantile(latencies_s, 1) * 1e3, tally.refused, tally.failed, tally.failure.c_str());
  report.Detail(text);
}

void AddAdvice(const Tally& batch, Report& report) {
  if (batch.advised_s.empty()) {
    report.Detail("  no batch was refused and taken later: no advice to compare");
    return;
  }
  std::vector<double> ratios;
  for (std::size_t i = 0; i < batch.advised_s.size(); ++i) {
    ratios.push_back(batch.actual_s[i] / std::max(1e-3, batch.advised_s[i]));
  }
  char text[240];
  std::snprintf(
      text, sizeof(text),
      "  retry advice of %zu batches: advised p50 %.2f s, p90 %.2f s; taken after p50 %.2f "
      "s, p90 %.2f s; taken over advised p50 %.1f, p90 %.1f",
      ratios.size(), Median(batch.advised_s), Quantile(batch.advised_s, 0.9),
      Median(batch.actual_s), Quantile(batch.actual_s, 0.9), Median(ratios), Quantile(ratios, 0.9));
  report.Detail(text);
  report.Add(WithLimit({.key = "overload_advice_ratio",
                        .value = Median(ratios),
                        .unit = "1",
                        .how = "median over refused batches, sent again after each advised delay: "
                               "time from the first refusal to the try that was taken, over the "
                               "first advice"},
                       3));
}

void AddFigures(const Alone& before, const Alone& after, double batch_alone_s,
                const Overload& overload, Report& report) {
  std::vector<double> idle_s = before.small_s;
  idle_s.insert(idle_s.end(), after.small_s.begin(), after.small_s.end());
  const double idle_p99_s = Quantile(idle_s, 0.99);
  char text[300];
  std::snprintf(
      text, sizeof(text),
      "p99 of CheckCollisions of one row every 5 ms beside 3 connections of batches, 2 of "
      "scans and 3 hostile clients, over the idle p99 of the same run: %.2f ms over %.2f ms",
      Quantile(overload.small.latencies_s, 0.99) * 1e3, idle_p99_s * 1e3);
  report.Add(WithLimit({.key = "overload_small_p99_ratio",
                        .value = Quantile(overload.small.latencies_s, 0.99) / idle_p99_s,
                        .unit = "1",
                        .how = text},
                       kMaxP99Ratio));
  report.Add(WithLimit({.key = "overload_small_failed",
                        .value = static_cast<double>(overload.small.failed),
                        .unit = "calls",
                        .how = "of those questions, calls that did not end OK within 10 s"},
                       0));
  const double batch_capacity = (before.batches_per_s + after.batches_per_s) / 2;
  const double scan_capacity = (before.scans_per_s + after.scans_per_s) / 2;
  const auto share = [&](std::size_t count, double capacity) {
    return capacity > 0 ? static_cast<double>(count) / overload.seconds / capacity : 0.0;
  };
  const double batch_share = share(overload.batches, batch_capacity);
  const double scan_share = share(overload.scans, scan_capacity);
  std::snprintf(text, sizeof(text),
                "batches of 10 000 rows answered a second in the overload over those answered when "
                "their 3 connections (8 in flight each) are alone, plus the same of scans (2 "
                "connections): %.2f + %.2f; alone %.0f rows/s, %.2f scans/s",
                batch_share, scan_share, batch_capacity * kBatchRows, scan_capacity);
  report.Add(WithLimit(
      {.key = "overload_goodput", .value = batch_share + scan_share, .unit = "1", .how = text},
      kMinGoodput, "limit, at least"));
  std::snprintf(text, sizeof(text),
                "longest time of a batch that was answered, less the %.3f s that one takes alone",
                batch_alone_s);
  report.Add(WithLimit({.key = "overload_batch_wait_s",
                        .value = Quantile(overload.batch.latencies_s, 1) - batch_alone_s,
                        .unit = "s",
                        .how = text},
                       kMaxWait_s));
}

}  // namespace

void MeasureOverload(Report& report) {
  MeasuredServer server;
  if (!server.up() || !PrepareOverload(server)) return report.Fail("no server for the overload");
  std::string failure;
  const double batch_alone_s = LatencyOfOneBatch_s(server);
  const Alone before = MeasureAlone(server, &failure);
  if (!failure.empty()) return report.Fail("a call failed without an overload: " + failure);
  Overload overload;
  RunOverload(server, overload);
  report.Detail("Overload of " + std::to_string(static_cast<int>(overload.seconds)) + " s, with " +
                std::to_string(overload.hostile) + " hostile requests:");
  PrintTally("small", overload.small, report);
  PrintTally("batches", overload.batch, report);
  PrintTally("scans", overload.scan, report);
  if (!server.running()) return report.Fail("the server died in the overload");
  Alone after = before;
  if (server.WaitUntilIdle(10)) {
    after = MeasureAlone(server, &failure);
    if (!failure.empty()) report.Detail("  a call failed after the overload: " + failure);
  } else {
    report.Detail("  still at work 10 s after the overload: the capacity is that before it");
  }
  AddFigures(before, after, batch_alone_s, overload, report);
  AddAdvice(overload.batch, report);
}

}  // namespace cwm::benchmarks
