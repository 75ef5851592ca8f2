// The cost of requests to the server beyond their cost to the sender: memory that they hold, and
// processor time after they are cancelled.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <regex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/benchmarks/server/hostile_request.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

using std::chrono::milliseconds;

constexpr double kMaxRatio = 100;       // bytes held over bytes sent
constexpr double kFreeBytes = 4 << 20;  // of each call
constexpr double kMaxCpu_ms = 20;       // of one thread after the cancel
constexpr double kHoldCpu_s = 4;        // a request that still works then is measured as it is
constexpr double kCancelCpu_s = 0.5;    // the same after it is cancelled
constexpr double kRequestLimit_s = 20;  // of one entry: further tries are skipped

struct Measured {
  bool prepared = true;
  bool died = false;
  bool works_on = false;  // still at work when it was measured
  double calls = 1;       // of a copy
  double sent_bytes = 0, held_bytes = 0, after_bytes = 0, peak_bytes = 0;  // of a copy
  double cpu_ms = 0;  // of the busiest thread after a cancel
  bool cpu_unended = false;
  std::string outcome;

  double kept_bytes() const { return std::max(held_bytes, after_bytes); }
  double ratio() const {
    return std::max(0.0, kept_bytes() - calls * kFreeBytes) / std::max(1.0, sent_bytes);
  }
};

std::string OutcomeOf(const Sent& sent) {
  std::map<std::string, int> counts;
  if (!sent.outcome.empty()) ++counts[sent.outcome];
  for (const auto& call : sent.calls) ++counts[call->Outcome()];
  std::string text;
  for (const auto& [name, count] : counts) {
    text += (text.empty() ? "" : ", ") + name;
    if (count > 1) text += " x " + std::to_string(count);
  }
  return text;
}

void CancelAll(Sent& sent) {
  for (const auto& call : sent.calls) call->Cancel();
  sent.others.clear();
}

// The peak of resident memory while the server works, up to the limit of its processor time.
double WatchPeak(const MeasuredServer& server, double cpu_limit_s, bool* idle) {
  double peak = 0;
  std::atomic<bool> over = false;
  std::thread watcher([&] {
    while (!over) {
      peak = std::max(peak, static_cast<double>(server.ResidentBytes()));
      std::this_thread::sleep_for(milliseconds(5));
    }
  });
  *idle = server.WaitUntilIdle(cpu_limit_s);
  over = true;
  watcher.join();
  return peak;
}

// Processor time of the busiest thread, in seconds; threads that have ended count together.
double BusiestSince(const MeasuredServer& server, const std::map<pid_t, double>& threads_s,
                    double total_s) {
  double busiest = 0, sum = 0;
  const double total = server.Cpu_s() - total_s;
  for (const auto& [thread, seconds] : server.ThreadCpu_s()) {
    const auto before = threads_s.find(thread);
    const double used = seconds - (before == threads_s.end() ? 0 : before->second);
    busiest = std::max(busiest, used);
    sum += used;
  }
  return std::max(busiest, total - sum);
}

// Cancels all calls and measures the processor time that the server still uses.
void Cancel(const MeasuredServer& server, std::vector<Sent>& copies, Measured& measured) {
  for (Sent& sent : copies) CancelAll(sent);
  // The cancels travel through the client's threads.
  for (Sent& sent : copies) {
    for (const auto& call : sent.calls) call->WaitUntilDone(milliseconds(200));
  }
  std::this_thread::sleep_for(milliseconds(2));
  const auto threads_s = server.ThreadCpu_s();
  const double total_s = server.Cpu_s();
  const bool ended = server.WaitUntilIdle(kCancelCpu_s);
  if (!server.running()) {
    measured.died = true;
    return;
  }
  measured.cpu_unended = measured.cpu_unended || !ended;
  measured.cpu_ms = std::max(measured.cpu_ms, BusiestSince(server, threads_s, total_s) * 1e3);
}

// Resident memory as soon as it is no more than `allowed`, at the latest after two seconds: memory
// that is free within the process may take a moment to be given back.
double SettledBytes(const MeasuredServer& server, double allowed) {
  constexpr double kSettleLimit_s = 2;
  const auto start = SteadyClock::now();
  auto bytes = static_cast<double>(server.ResidentBytes());
  while (bytes > allowed && SecondsSince(start) < kSettleLimit_s) {
    std::this_thread::sleep_for(milliseconds(50));
    bytes = std::min(bytes, static_cast<double>(server.ResidentBytes()));
  }
  return bytes;
}

void MeasureHeld(const HostileRequest& request, const Target& target, Measured& measured) {
  MeasuredServer& server = target.server;
  server.WaitUntilIdle(2);
  const auto before = static_cast<double>(server.ResidentBytes());
  std::vector<Sent> copies(static_cast<std::size_t>(request.copies));
  for (int copy = 0; copy < request.copies; ++copy) {
    request.send(target, copy, copies[static_cast<std::size_t>(copy)]);
  }
  bool idle = false;
  const double peak = WatchPeak(server, kHoldCpu_s, &idle);
  double content = 0;
  for (const Sent& sent : copies) {
    measured.sent_bytes += static_cast<double>(sent.bytes) / request.copies;
    content += static_cast<double>(sent.content_bytes);
  }
  measured.calls = std::max(1.0, static_cast<double>(copies[0].calls.size()));
  const double allowed =
      before + content +
      request.copies * (measured.calls * kFreeBytes + kMaxRatio * measured.sent_bytes);
  const double held = SettledBytes(server, allowed);
  measured.works_on = !idle;
  measured.outcome = OutcomeOf(copies[0]);
  Cancel(server, copies, measured);
  const double after = SettledBytes(server, allowed);
  measured.died = !server.running();
  const auto per_copy = [&](double bytes) { return (bytes - before - content) / request.copies; };
  measured.held_bytes = per_copy(held);
  measured.after_bytes = per_copy(after);
  measured.peak_bytes = per_copy(std::max(peak, held));
}

void MeasureCancelled(const HostileRequest& request, const Target& target, int copy,
                      milliseconds delay, Measured& measured) {
  std::vector<Sent> copies(1);
  request.send(target, copy, copies[0]);
  std::this_thread::sleep_for(delay);
  Cancel(target.server, copies, measured);
}

Measured Measure(const HostileRequest& request) {
  const auto start = SteadyClock::now();
  Measured measured;
  MeasuredServer server;
  Target target{.server = server};
  const int needed = request.copies + kCpuTries;
  if (!server.up() || (request.prepare && !request.prepare(target, needed))) {
    measured.prepared = false;
    measured.died = !server.running();
    return measured;
  }
  MeasureHeld(request, target, measured);
  if (!request.has_cpu) return measured;
  const milliseconds delays[kCpuTries] = {milliseconds(3), milliseconds(50), milliseconds(300)};
  // A request that does not end is not tried again, because its work would be counted as the next
  // one's.
  for (int i = 0; i < kCpuTries && !measured.died && !measured.cpu_unended; ++i) {
    if (SecondsSince(start) > kRequestLimit_s) break;
    MeasureCancelled(request, target, request.copies + i, delays[i], measured);
  }
  return measured;
}

bool IsOver(const HostileRequest& request, const Measured& measured) {
  return request.known_issue.empty() && (measured.died || measured.ratio() > kMaxRatio ||
                                         (request.has_cpu && measured.cpu_ms > kMaxCpu_ms));
}

std::string LineOf(const HostileRequest& request, const Measured& measured) {
  char text[320];
  if (!measured.prepared) {
    std::snprintf(text, sizeof(text), "  %-37s could not be prepared%s", request.name.c_str(),
                  measured.died ? ": server died" : "");
    return text;
  }
  char cpu[32] = "        -";
  if (request.has_cpu) {
    std::snprintf(cpu, sizeof(cpu), "%s%8.1f", measured.cpu_unended ? ">" : " ", measured.cpu_ms);
  }
  std::snprintf(text, sizeof(text), "  %-37s %11.0f %9.2f %9.2f %9.2f %9.0f %s  %s%s%s%s",
                request.name.c_str(), measured.sent_bytes, measured.held_bytes / kMebi,
                measured.after_bytes / kMebi, measured.peak_bytes / kMebi, measured.ratio(), cpu,
                measured.outcome.c_str(), measured.works_on ? ", still at work" : "",
                measured.died ? "  SERVER DIED" : "", IsOver(request, measured) ? "  OVER" : "");
  std::string line = text;
  if (!request.known_issue.empty()) line += "  (not judged: " + request.known_issue + ")";
  return line;
}

}  // namespace

void MeasureAmplificationOf(const std::string& pattern, Report& report) {
  const std::regex names(pattern);
  report.Detail(
      "Amplification, of one copy: bytes sent; MiB held beyond content, open, after its end, at "
      "the "
      "peak; (held - 4 MiB a call) / sent, at most 100; CPU ms of the busiest thread after a "
      "cancel, at "
      "most 20:");
  char head[200];
  std::snprintf(head, sizeof(head), "  %-37s %11s %9s %9s %9s %9s %9s  %s", "request", "sent B",
                "open MiB", "after MiB", "peak MiB", "ratio", "CPU ms", "outcome");
  report.Detail(head);
  double worst_ratio = 0, worst_cpu_ms = 0;
  std::string worst_held, worst_cpu;
  int count = 0, over = 0, deaths = 0;
  for (const HostileRequest& request : HostileRequests()) {
    if (!std::regex_search(request.name, names)) continue;
    const Measured measured = Measure(request);
    report.Detail(LineOf(request, measured));
    ++count;
    deaths += measured.died ? 1 : 0;
    over += IsOver(request, measured) ? 1 : 0;
    if (!measured.prepared) report.Fail(request.name + " could not be prepared");
    if (!request.known_issue.empty()) continue;
    if (measured.ratio() > worst_ratio) {
      worst_ratio = measured.ratio();
      worst_held = request.name;
    }
    if (request.has_cpu && measured.cpu_ms > worst_cpu_ms) {
      worst_cpu_ms = measured.cpu_ms;
      worst_cpu = request.name;
    }
  }
  if (count == 0) return report.Fail("no hostile request has a name like " + pattern);
  report.Add(
      WithLimit({.key = "amplification_bytes",
                 .value = worst_ratio,
                 .unit = "1",
                 .how = "the most anonymous resident memory beyond the stored encoding that a copy "
                        "of a request holds, open or after its end, less 4 MiB, over its bytes "
                        "sent; worst of " +
                        std::to_string(count) + " requests: " + worst_held},
                kMaxRatio));
  report.Add(
      WithLimit({.key = "amplification_cpu",
                 .value = worst_cpu_ms,
                 .unit = "ms",
                 .how = "processor time of the busiest thread from 2 ms after the client's "
                        "cancel until the server is idle or has used 0.5 s; cancelled 3, 50 and "
                        "300 ms after it was sent; worst: " +
                        worst_cpu},
                kMaxCpu_ms));
  report.Add(
      WithLimit({.key = "amplification_over",
                 .value = static_cast<double>(over),
                 .unit = "requests",
                 .how = "requests of the table beyond either limit, or that ended the server (" +
                        std::to_string(deaths) + ")"},
                0));
}

void MeasureAmplification(Report& report) { MeasureAmplificationOf("", report); }

}  // namespace cwm::benchmarks
