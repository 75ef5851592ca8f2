// The Panda through a running server: states per second of a stream, beside the same batches in
// process, and the latency of single states.
#include <grpcpp/grpcpp.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "collision/query/robot_body.h"
#include "collision/robot/kinematics.h"
#include "grpc/health/v1/health.grpc.pb.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/panda_server.h"
#include "tests/benchmarks/running_server.h"

namespace cwm::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

constexpr char kWorld[] = "problem";
constexpr std::size_t kBatch = 10'000;
// Spheres are measured in all 700 problems, meshes, which take ten times as long, in every tenth.
constexpr std::size_t kProblemStepOfMeshes = 10;
// For a client that does not wait for an answer before it sends the next query.
constexpr int kInFlight = 3;
constexpr int kBatches = 6;

// Processor time of a process so far, over all its threads.
double ProcessorTime_s(pid_t pid) {
  clockid_t clock = 0;
  timespec time = {};
  if (clock_getcpuclockid(pid, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double Since_s(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// A stream that stays open.
class Stream {
 public:
  explicit Stream(const client::Connection& connection)
      : stream_(connection.queries().StreamQueries(&context_)) {}
  ~Stream() {
    stream_->WritesDone();
    v1::StreamQueriesResponse ignored;
    while (stream_->Read(&ignored)) {
    }
    // Evaluate has already reported an error.
    static_cast<void>(stream_->Finish());
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  // The answer to a query; empty if the call failed.
  std::string Evaluate(const v1::CheckCollisionsRequest& query) {
    return Send(query) ? Receive() : "";
  }

  // Sends the query `times` times with kInFlight of them in flight; false if one failed.
  bool EvaluateRepeatedly(const v1::CheckCollisionsRequest& query, int times) {
    bool good = true;
    for (int i = 0; i < times + kInFlight && good; ++i) {
      if (i < times) good = Send(query);
      if (i >= kInFlight) good = good && !Receive().empty();
    }
    return good;
  }

 private:
  // Each message is built anew, as a planner's is.
  bool Send(const v1::CheckCollisionsRequest& query) {
    v1::StreamQueriesRequest request;
    *request.mutable_check_collisions() = query;
    return stream_->Write(request);
  }

  std::string Receive() {
    v1::StreamQueriesResponse response;
    if (!stream_->Read(&response) || response.has_error()) return "";
    return std::move(*response.mutable_check_collisions()->mutable_verdicts());
  }

  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamQueriesRequest, v1::StreamQueriesResponse>>
      stream_;
};

struct Rates {
  // Per state: through a stream with one batch in flight and with several, and in process.
  std::vector<double> one_us, through_us, within_us;
  // Processor time per state: of client and server with several batches in flight, and in process.
  std::vector<double> client_cpu_us, server_cpu_us, within_cpu_us;
  std::size_t mismatches = 0;
};

collision::QueryBody BodyOf(const collision::RobotGeometry& robot, v1::RobotGeometry geometry) {
  return geometry == v1::ROBOT_GEOMETRY_EXACT
             ? BodyFromRobot(robot, collision::RobotScope::kBoth)
             : BodyFromSpheres(robot, *robot.prepared_spheres_as_given,
                               collision::RobotScope::kBoth);
}

// The client's stream and the server that it queries.
struct StreamTarget {
  const PandaProblems& all;
  v1::RobotGeometry geometry;
  pid_t server;
  Stream& stream;
  std::size_t* problem;  // the one whose objects are in the world
};

// Measures several batches in flight; false if one failed.
bool MeasureInFlight(const StreamTarget& target, const v1::CheckCollisionsRequest& query,
                     Rates& rates) {
  const double states = static_cast<double>(kBatch) * kBatches;
  const double client_s = ProcessorTime_s(getpid()), server_s = ProcessorTime_s(target.server);
  const Clock::time_point start = Clock::now();
  if (!target.stream.EvaluateRepeatedly(query, kBatches)) return false;
  rates.through_us.push_back(1e6 * Since_s(start) / states);
  rates.client_cpu_us.push_back(1e6 * (ProcessorTime_s(getpid()) - client_s) / states);
  rates.server_cpu_us.push_back(1e6 * (ProcessorTime_s(target.server) - server_s) / states);
  return true;
}

// Measures the same states in process and through the stream, in turn; false if the stream failed.
bool Compare(const StreamTarget& target, std::size_t k, Rates& rates) {
  const PandaProblems& all = target.all;
  const PandaProblem& problem = all.problems[k];
  const std::vector<double> states = RandomStates(all, problem, kBatch, k);
  const collision::JointRows rows(
      *all.robot->model, *all.arm,
      {.base = collision::DefaultVariables(*all.robot->model), .rows = states});
  const auto query = PandaIn(kWorld, states, target.geometry);
  Clock::time_point start = Clock::now();
  const double cpu_s = ProcessorTime_s(getpid());
  const auto columns =
      *collision::CheckCollisions(*problem.world, BodyOf(*all.robot, target.geometry), rows,
                                  {.naming = collision::Naming::kWhereTested});
  rates.within_us.push_back(1e6 * Since_s(start) / kBatch);
  rates.within_cpu_us.push_back(1e6 * (ProcessorTime_s(getpid()) - cpu_s) / kBatch);
  start = Clock::now();
  const std::string verdicts = target.stream.Evaluate(query);
  rates.one_us.push_back(1e6 * Since_s(start) / kBatch);
  if (verdicts.size() != kBatch) return false;
  for (std::size_t row = 0; row < kBatch; ++row) {
    const bool collides = columns.verdict[row] == collision::Verdict::kCollision;
    rates.mismatches += collides != (verdicts[row] == v1::VERDICT_COLLISION) ? 1 : 0;
  }
  return MeasureInFlight(target, query, rates);
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// Measures all problems, or some of each family. The world contains the objects of the problem
// measured before.
std::optional<Rates> MeasureStreamOf(const StreamTarget& target,
                                     const client::Connection& connection, Report& report) {
  const std::size_t step = target.geometry == v1::ROBOT_GEOMETRY_EXACT ? kProblemStepOfMeshes : 1;
  const std::vector<PandaProblem>& problems = target.all.problems;
  Rates rates;
  for (std::size_t k = 0; k < problems.size(); k += step) {
    const absl::Status put =
        ReplacePandaProblem(connection, problems[*target.problem], problems[k], kWorld);
    *target.problem = k;
    if (put.ok() && Compare(target, k, rates)) continue;
    report.Fail("a batch of the Panda failed on the stream: " + std::string(put.message()));
    return std::nullopt;
  }
  if (rates.mismatches > 0) {
    report.Fail(std::to_string(rates.mismatches) + " verdicts of the stream are not the core's");
  }
  char text[300];
  std::snprintf(
      text, sizeof(text),
      "the Panda, %s, %zu problems: %.2f us a state with %d batches in flight, %.2f us with one, "
      "in process %.2f "
      "us; of a processor %.2f us in the client, %.2f us in the server, in process %.2f us",
      target.geometry == v1::ROBOT_GEOMETRY_EXACT ? "meshes" : "spheres as given",
      rates.through_us.size(), Mean(rates.through_us), kInFlight, Mean(rates.one_us),
      Mean(rates.within_us), Mean(rates.client_cpu_us), Mean(rates.server_cpu_us),
      Mean(rates.within_cpu_us));
  report.Detail(text);
  return rates;
}

bool PutFirstProblem(const RunningServer& server, const PandaProblems& all, Report& report) {
  const absl::Status put = PutPandaProblem(server.connection(), all.problems[0], kWorld);
  if (!put.ok()) report.Fail("no world for the Panda: " + std::string(put.message()));
  return put.ok();
}

// Latencies of unary calls, empty if one failed: queries about one state, each followed by a health
// check, which shows what gRPC itself takes on the same connection.
struct Latencies {
  std::vector<double> state_ms, health_ms;

  bool empty() const { return state_ms.empty() || health_ms.empty(); }
  Figure AsFigure(const std::string& key, const std::string& how) const {
    return {.key = key,
            .value = Median(state_ms),
            .unit = "ms",
            .baseline = "health check",
            .baseline_value = Median(health_ms),
            .ratio = Median(health_ms) / Median(state_ms),
            .how = how};
  }
  std::string FormatQuantiles(const std::string& name) const {
    char text[160];
    std::snprintf(text, sizeof(text), "%s: p99 of a state %.2f ms, of a health check %.2f ms",
                  name.c_str(), Quantile(state_ms, 0.99), Quantile(health_ms, 0.99));
    return text;
  }
};

// Queries one state, or checks health, after a pause.
class Caller {
 public:
  Caller(const client::Connection& connection, const PandaProblems& all)
      : connection_(connection),
        query_(PandaIn(kWorld, RandomStates(all, all.problems[0], 1, 1), v1::ROBOT_GEOMETRY_EXACT)),
        checks_(grpc::health::v1::Health::NewStub(connection.channel())) {}

  // Each adds its latency to `taken_ms`; false if the call failed.
  bool QueryState(double pause_s, std::vector<double>& taken_ms) const {
    return Measure(pause_s, taken_ms, &v1::QueryService::Stub::CheckCollisions,
                   connection_.queries(), query_);
  }
  bool CheckHealth(double pause_s, std::vector<double>& taken_ms) const {
    return Measure(pause_s, taken_ms, &grpc::health::v1::Health::Stub::Check, *checks_,
                   grpc::health::v1::HealthCheckRequest());
  }

 private:
  template <class Method, class Stub, class Request>
  bool Measure(double pause_s, std::vector<double>& taken_ms, Method method, Stub& stub,
               const Request& request) const {
    if (pause_s > 0) std::this_thread::sleep_for(std::chrono::duration<double>(pause_s));
    const Clock::time_point start = Clock::now();
    const bool succeeded = connection_.Call(method, stub, request).ok();
    taken_ms.push_back(1e3 * Since_s(start));
    return succeeded;
  }

  const client::Connection& connection_;
  const v1::CheckCollisionsRequest query_;
  const std::unique_ptr<grpc::health::v1::Health::Stub> checks_;
};

// `count` of each, one after the other.
Latencies MeasureLatencies(const Caller& caller, int count, double pause_s) {
  Latencies latencies;
  for (int i = 0; i < count; ++i) {
    if (!caller.QueryState(pause_s, latencies.state_ms) ||
        !caller.CheckHealth(pause_s, latencies.health_ms))
      return {};
  }
  return latencies;
}

}  // namespace

void MeasureRobotStream(Report& report) {
  const std::optional<PandaProblems> all = ReadPandaProblems();
  if (!all) return report.Detail("skipped: motion_bench_maker is not in CWM_DATA");
  const RunningServer server;
  if (!server.up()) return report.Fail("no server");
  if (!PutFirstProblem(server, *all, report)) return;
  Stream stream(server.connection());
  std::size_t problem = 0;
  const auto measure = [&](v1::RobotGeometry geometry) {
    return MeasureStreamOf({*all, geometry, server.pid(), stream, &problem}, server.connection(),
                           report);
  };
  const auto exact = measure(v1::ROBOT_GEOMETRY_EXACT);
  const auto spheres = measure(v1::ROBOT_GEOMETRY_SPHERES_AS_GIVEN);
  if (!exact || !spheres) return;
  const auto add = [&](const std::string& key, const std::string& what, const Rates& rates) {
    report.Add(
        {.key = key,
         .value = 1e6 / Mean(rates.through_us),
         .unit = "1/s",
         .baseline = "in process, one thread",
         .baseline_value = 1e6 / Mean(rates.within_us),
         .ratio = Mean(rates.within_us) / Mean(rates.through_us),
         .how = "verdicts of " + what +
                " against scene and self, batches of 10 000 on one StreamQueries over the "
                "Unix socket, three in flight, client and server share the machine; mean of " +
                std::to_string(rates.through_us.size()) + " problems"});
  };
  add("panda_stream_states_per_s", "the Panda's 59 spheres as given", *spheres);
  add("panda_exact_stream_states_per_s", "the Panda's meshes", *exact);
  report.Add({.key = "panda_stream_cpu_us",
              .value = Mean(spheres->client_cpu_us) + Mean(spheres->server_cpu_us),
              .unit = "us",
              .baseline = "in process",
              .baseline_value = Mean(spheres->within_cpu_us),
              .how = "processor time of client and server for a state of the spheres as given, in "
                     "the same run"});
}

void MeasureRobotLatency(Report& report) {
  const std::optional<PandaProblems> all = ReadPandaProblems();
  if (!all) return report.Detail("skipped: motion_bench_maker is not in CWM_DATA");
  const RunningServer server;
  if (!server.up()) return report.Fail("no server");
  if (!PutFirstProblem(server, *all, report)) return;
  const Caller caller(server.connection(), *all);
  std::vector<double> idle_ms;
  for (int i = 0; i < 20; ++i) {
    if (!caller.QueryState(3.0, idle_ms)) return report.Fail("a unary call failed");
  }
  const Latencies in_a_row = MeasureLatencies(caller, 2'000, 0);
  const Latencies paced = MeasureLatencies(caller, 200, 0.02);
  const auto beside = [&](v1::RobotGeometry geometry, std::size_t batch, int count,
                          double pause_s) {
    const auto query = PandaIn(kWorld, RandomStates(*all, all->problems[0], batch, 2), geometry);
    std::atomic<bool> stop = false;
    std::thread load([&] {
      // A planner beside a control loop: each has its own connection.
      const client::Connection planner(
          {.address = server.connection().address(), .deadline = std::nullopt});
      Stream stream(planner);
      while (!stop && stream.EvaluateRepeatedly(query, 10)) {
      }
    });
    Latencies latencies = MeasureLatencies(caller, count, pause_s);
    stop = true;
    load.join();
    return latencies;
  };
  const Latencies loaded = beside(v1::ROBOT_GEOMETRY_EXACT, 1'000, 200, 0.02);
  const Latencies loaded_in_a_row = beside(v1::ROBOT_GEOMETRY_EXACT, 1'000, 2'000, 0);
  const Latencies spheres = beside(v1::ROBOT_GEOMETRY_SPHERES_AS_GIVEN, kBatch, 200, 0.02);
  if (in_a_row.empty() || paced.empty() || loaded.empty() || loaded_in_a_row.empty() ||
      spheres.empty())
    return report.Fail("a unary call failed");
  report.Add({.key = "unary_idle_p99_ms",
              .value = Quantile(idle_ms, 0.99),
              .unit = "ms",
              .baseline = "median",
              .baseline_value = Median(idle_ms),
              .how = "CheckCollisions of one state of the Panda's meshes over the Unix socket, 20 "
                     "calls 3 s apart to an idle server; the longest of them"});
  report.Add(in_a_row.AsFigure("unary_in_a_row_p50_ms",
                               "2 000 such calls and as many of gRPC's own health check, which the "
                               "transport alone answers, in turn, each as soon as the one before "
                               "is answered"));
  report.Add(paced.AsFigure("unary_paced_p50_ms",
                            "200 of each 20 ms apart, beside nothing: what of the next figures is "
                            "the pause"));
  report.Add(loaded.AsFigure("unary_loaded_p50_ms",
                             "the same while one stream asks batches of 1 000 states, three in "
                             "flight"));
  report.Add(loaded_in_a_row.AsFigure("unary_loaded_in_a_row_p50_ms",
                                      "beside the same batches, 2 000 of each in a row"));
  report.Add(spheres.AsFigure("unary_beside_spheres_p50_ms",
                              "the same beside batches of 10 000 states of the spheres as given"));
  report.Detail(in_a_row.FormatQuantiles("in a row"));
  report.Detail(paced.FormatQuantiles("20 ms apart"));
  report.Detail(loaded.FormatQuantiles("beside batches of meshes"));
  report.Detail(loaded_in_a_row.FormatQuantiles("in a row beside batches of meshes"));
  report.Detail(spheres.FormatQuantiles("beside batches of spheres"));
}

}  // namespace cwm::benchmarks
