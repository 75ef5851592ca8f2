// The time that a server takes to stop, and the status that its clients receive.
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "clients/cpp/call_error.h"
#include "tests/benchmarks/server/held_call.h"
#include "tests/benchmarks/server/hostile_content.h"
#include "tests/benchmarks/server/measured_server.h"
#include "tests/benchmarks/server/server_benchmarks.h"
#include "tests/support/process.h"

namespace cwm::benchmarks {
namespace {

constexpr int kPythonPrograms = 2, kPythonChannels = 10;  // of each
constexpr int kIdleClients = 100;
constexpr double kStopLimit_s = 30;

CallPlan InfoPlan() { return {.method = "cwm.v1.AdminService/GetServerInfo", .messages = {""}}; }

class PythonClients {
 public:
  explicit PythonClients(const std::string& address)
      : program_({"/usr/bin/python3", CWM_IDLE_CHANNELS_SCRIPT, address,
                  std::to_string(kPythonChannels)},
                 scratch_ / "python.log") {}
  ~PythonClients() { program_.Signal(SIGKILL); }
  PythonClients(const PythonClients&) = delete;
  PythonClients& operator=(const PythonClients&) = delete;

  bool WaitUntilReady(double limit_s) const {
    const auto start = SteadyClock::now();
    while (SecondsSince(start) < limit_s && program_.Running()) {
      std::string line;
      std::ifstream log(scratch_ / "python.log");
      while (std::getline(log, line)) {
        if (line == "ready") return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }

 private:
  testing::ScratchDirectory scratch_;
  testing::BackgroundProcess program_;
};

// The time to stop, in seconds; empty if it could not be measured.
std::optional<double> StopBesideIdle(int python_programs, int clients, Report& report) {
  MeasuredServer server;
  if (!server.up()) return std::nullopt;
  std::vector<std::unique_ptr<PythonClients>> python;
  for (int i = 0; i < python_programs; ++i) {
    python.push_back(std::make_unique<PythonClients>("unix:" + server.socket_path()));
  }
  std::vector<std::unique_ptr<HeldCall>> calls;
  std::vector<std::shared_ptr<grpc::Channel>> channels;
  for (int i = python_programs * kPythonChannels; i < clients; ++i) {
    channels.push_back(server.NewChannel());
    HeldCall call(channels.back(), InfoPlan());
    if (!call.WaitUntilDone(std::chrono::seconds(10))) return std::nullopt;
  }
  for (const auto& program : python) {
    if (!program->WaitUntilReady(30)) {
      report.Detail("the Python clients did not come up (python3-grpcio is in the test packages)");
      return std::nullopt;
    }
  }
  server.WaitUntilIdle(2);
  return server.Stop_s(kStopLimit_s).value_or(kStopLimit_s);
}

void MeasureIdleStops(Report& report) {
  const auto none = StopBesideIdle(0, 0, report);
  const auto plain = StopBesideIdle(0, kIdleClients, report);
  const auto python = StopBesideIdle(kPythonPrograms, kIdleClients, report);
  if (!none || !plain || !python) return report.Fail("a stop beside idle clients was not measured");
  char text[200];
  std::snprintf(
      text, sizeof(text),
      "Stops: %.2f s without clients, %.2f s with 100 idle C++ channels, %.2f s where 20 of "
      "the 100 are Python's (at most 1)",
      *none, *plain, *python);
  report.Detail(text);
  report.Add(
      WithLimit({.key = "stop_idle_clients_s",
                 .value = std::max({*none, *plain, *python}),
                 .unit = "s",
                 .how = "SIGTERM to the end of the process, the worst of no client, 100 idle "
                        "C++ channels, and 80 of those with 20 idle Python channels; each "
                        "channel has made one call"},
                1));
}

// The outcomes of calls that were in flight at the signal, and of those begun after it.
struct Ends {
  std::mutex mutex;
  std::map<std::string, int> under_way, begun_after;
  int unexplained = 0;
};

class LoadOnStop {
 public:
  explicit LoadOnStop(MeasuredServer& server) : server_(server) {}

  // Adds a client that makes the calls of `plan` one after another until one fails after the
  // signal.
  void Add(const std::string& kind, CallPlan plan) {
    threads_.emplace_back([this, kind, plan = std::move(plan)] { Run(kind, plan); });
  }

  double StopAndJoin() {
    signalled_ = true;
    const double stop_s = server_.Stop_s(kStopLimit_s).value_or(kStopLimit_s);
    over_ = true;
    for (std::thread& thread : threads_) thread.join();
    return stop_s;
  }

  Ends& ends() { return ends_; }

 private:
  void Run(const std::string& kind, const CallPlan& plan) {
    const auto channel = server_.NewChannel();
    while (!over_) {
      const bool begun_before = !signalled_;
      HeldCall call(channel, plan);
      while (!call.WaitUntilDone(std::chrono::milliseconds(100))) {
        if (over_) break;
      }
      if (!signalled_) {
        // A refusal before the signal has nothing to do with the stop.
        if (!call.status().ok()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
        continue;
      }
      Note(kind, begun_before, call);
      if (!call.status().ok() || call.Outcome() == "open") return;
    }
  }

  void Note(const std::string& kind, bool begun_before, const HeldCall& call) {
    const grpc::Status status = call.status();
    const client::ErrorDetails details = client::DetailsOf(client::StatusFromGrpc(status));
    std::string end = call.Outcome();
    const bool draining = details.reason == "SERVER_DRAINING" && details.retry_after_s.has_value();
    if (draining) end = "SERVER_DRAINING";
    if (!draining && !details.reason.empty()) end += " " + details.reason;
    const bool explained = end == "OK" || draining || details.retry_after_s.has_value();
    const std::lock_guard lock(ends_.mutex);
    if (begun_before) {
      ++ends_.under_way[explained ? end : kind + ": " + end];
      ends_.unexplained += explained ? 0 : 1;
    } else {
      ++ends_.begun_after[end];
    }
  }

  MeasuredServer& server_;
  Ends ends_;
  std::atomic<bool> signalled_ = false, over_ = false;
  std::vector<std::thread> threads_;
};

CallPlan Distances(int rows) {
  v1::GetDistancesRequest request;
  request.set_world("w");
  request.mutable_subject()->mutable_shapes()->add_shapes()->mutable_box()->set_size_x_m(0.1);
  v1::Box* box = request.mutable_subject()->mutable_shapes()->mutable_shapes(0)->mutable_box();
  box->set_size_y_m(0.1);
  box->set_size_z_m(0.1);
  request.mutable_subject()->mutable_shapes()->mutable_x_world_body()->set_data(PoseBytes(rows, 0));
  request.mutable_options()->set_max_results(8);
  return UnaryPlan("cwm.v1.QueryService/GetDistances", request);
}

void AddLoad(LoadOnStop& load) {
  for (int i = 0; i < 12; ++i) load.Add("small question", Distances(1));
  for (int i = 0; i < 6; ++i) load.Add("batch", Distances(10'000));
  v1::ApplyChangesRequest change;
  change.set_world("w");
  v1::MoveObject* move = change.add_changes()->mutable_move();
  move->set_name("box_0");
  for (int i = 0; i < 4; ++i) {
    move->mutable_x_world_object()->set_tx_m(i);
    move->mutable_x_world_object()->set_qw(1);
    load.Add("change", UnaryPlan("cwm.v1.WorldService/ApplyChanges", change));
  }
  v1::WatchWorldRequest watch;
  watch.set_world("w");
  for (int i = 0; i < 4; ++i) load.Add("watch", UnaryPlan("cwm.v1.WorldService/WatchWorld", watch));
  v1::GetWorldRequest wait;
  wait.set_world("w");
  wait.mutable_at_revision()->set_at_least(1'000'000'000);
  for (int i = 0; i < 4; ++i) load.Add("wait", UnaryPlan("cwm.v1.WorldService/GetWorld", wait));
  CallPlan stream{.method = "cwm.v1.QueryService/StreamQueries", .half_closes = false};
  v1::StreamQueriesRequest query;
  query.mutable_get_distances()->ParseFromString(Distances(1'000).messages[0]);
  stream.messages.assign(3, query.SerializeAsString());
  for (int i = 0; i < 4; ++i) load.Add("stream", stream);
  load.Add("scan", CloudUploadPlan("scan", NoisePoints(20'000)));
  CallPlan half = CloudUploadPlan("half", NoisePoints(1'000));
  half.messages.pop_back();
  half.half_closes = false;
  for (int i = 0; i < 2; ++i) load.Add("half upload", half);
}

std::string TextOf(const std::map<std::string, int>& counts) {
  std::string text;
  for (const auto& [end, count] : counts) {
    absl::StrAppend(&text, text.empty() ? "" : ", ", end, " x ", count);
  }
  return text.empty() ? "none" : text;
}

void MeasureStopsUnderLoad(Report& report) {
  constexpr int kRounds = 3;
  double worst_s = 0;
  int unexplained = 0;
  std::map<std::string, int> under_way, begun_after;
  for (int round = 0; round < kRounds; ++round) {
    MeasuredServer server;
    if (!server.up() || !PutBoxes(server, "w", 2'000)) {
      return report.Fail("no server for a stop under load");
    }
    LoadOnStop load(server);
    AddLoad(load);
    std::this_thread::sleep_for(std::chrono::milliseconds(1'500));
    worst_s = std::max(worst_s, load.StopAndJoin());
    unexplained += load.ends().unexplained;
    for (const auto& [end, count] : load.ends().under_way) under_way[end] += count;
    for (const auto& [end, count] : load.ends().begun_after) begun_after[end] += count;
  }
  report.Detail("Calls under way at SIGTERM ended: " + TextOf(under_way));
  report.Detail("Calls begun after it ended: " + TextOf(begun_after));
  report.Add(WithLimit({.key = "stop_load_s",
                        .value = worst_s,
                        .unit = "s",
                        .how = "the same under load, the worst of three: 39 clients with small "
                               "questions, batches, changes, watches, waits, streams and uploads"},
                       1));
  report.Add(WithLimit({.key = "stop_calls_unexplained",
                        .value = static_cast<double>(unexplained),
                        .unit = "calls",
                        .how = "calls under way at SIGTERM, in three stops under load, that ended "
                               "neither OK nor with SERVER_DRAINING and RetryInfo"},
                       0));
}

}  // namespace

void MeasureStops(Report& report) {
  MeasureIdleStops(report);
  MeasureStopsUnderLoad(report);
}

}  // namespace cwm::benchmarks
