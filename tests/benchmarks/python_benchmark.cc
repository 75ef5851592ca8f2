// Batches of robot states queried by the Python client and by the C++ client, in turn, from one
// server.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "clients/cpp/robot_upload.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/panda_server.h"
#include "tests/benchmarks/running_server.h"
#include "tests/collision/robot/robot_text.h"
#include "tests/support/process.h"

namespace cwm::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

// One problem of each family; the 700 are ordered by family.
constexpr std::size_t kProblemStep = 100;
constexpr std::size_t kBatch = 10'000;
constexpr int kBatches = 30;
// The same number as in python_batches.py: a new connection adapts its flow-control window first.
constexpr int kWarmUp = 10;
constexpr int kRounds = 3;

// A query about a robot of a world, with its states.
struct RobotQuery {
  v1::CheckCollisionsRequest request;  // with the states
  std::vector<double> states;
};

struct Times {
  double batch_s = 0;          // median
  std::size_t collisions = 0;  // of one batch: both must find the same
};

// Each request is made anew, as a planner's is, over a connection of its own like Python's.
std::optional<Times> EvaluateInCpp(const std::string& address, const RobotQuery& query) {
  const client::Connection connection({.address = address, .deadline = std::nullopt});
  Times times;
  std::vector<double> times_s;
  for (int i = 0; i < kWarmUp + kBatches; ++i) {
    const Clock::time_point start = Clock::now();
    v1::CheckCollisionsRequest request = query.request;
    const auto answer =
        connection.Call(&v1::QueryService::Stub::CheckCollisions, connection.queries(), request);
    if (!answer.ok()) return std::nullopt;
    times.collisions = 0;
    for (const char verdict : answer->verdicts()) {
      times.collisions += verdict == v1::VERDICT_COLLISION ? 1 : 0;
    }
    if (i < kWarmUp) continue;
    times_s.push_back(std::chrono::duration<double>(Clock::now() - start).count());
  }
  times.batch_s = Median(times_s);
  return times;
}

// Parses Python's answer, which is JSON; any other output goes to `error`.
std::optional<Times> EvaluateInPython(const client::Connection& connection, const RobotQuery& query,
                                      const testing::ScratchDirectory& scratch,
                                      std::string& error) {
  const std::string states = scratch / "states.f64";
  std::ofstream(states, std::ios::binary)
      .write(reinterpret_cast<const char*>(query.states.data()),
             static_cast<std::streamsize>(query.states.size() * sizeof(double)));
  const auto package =
      std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "python";
  const v1::RobotSubject& robot = query.request.subject().robot();
  const testing::ProcessResult run = testing::RunProgram(
      {"/usr/bin/env", "PYTHONPATH=" + package.string(), "/usr/bin/python3",
       CWM_PYTHON_BATCHES_SCRIPT, connection.address(), query.request.world(), robot.robot(),
       robot.group(), states, std::to_string(kBatch), std::to_string(kBatches)});
  const auto answer = nlohmann::json::parse(run.out, nullptr, /*allow_exceptions=*/false);
  if (run.exit_code != 0 || !answer.is_object()) {
    error = run.err;
    return std::nullopt;
  }
  return Times{.batch_s = answer.value("batch_s", 0.0),
               .collisions = answer.value("collisions", std::size_t{0})};
}

// A small robot in the benchmark world, for machines without the planning problems.
absl::StatusOr<RobotQuery> OwnQuery(const client::Connection& connection) {
  v1::LoadRobotHeader header;
  header.set_name("balls");
  header.set_urdf(collision::testing::Robot(collision::testing::ThreeBalls()));
  header.set_spheres(header.urdf());
  const auto loaded = client::LoadRobot(connection, header, {});
  if (!loaded.ok()) return loaded.status();
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle_rad(-3, 3);
  std::vector<double> states(2 * kBatch);
  for (double& value : states) value = angle_rad(random);
  v1::CheckCollisionsRequest request =
      PandaIn("default", states, v1::ROBOT_GEOMETRY_SPHERES_AS_GIVEN);
  request.mutable_subject()->mutable_robot()->set_robot("balls");
  request.mutable_subject()->mutable_robot()->clear_group();
  return RobotQuery{std::move(request), std::move(states)};
}

std::vector<RobotQuery> MakeQueries(const client::Connection& connection, Report& report) {
  std::vector<RobotQuery> queries;
  const std::optional<PandaProblems> all = ReadPandaProblems();
  if (!all) {
    report.Detail(
        "motion_bench_maker is not in CWM_DATA: a robot of three balls instead of the Panda");
    auto own = OwnQuery(connection);
    if (!own.ok()) {
      report.Detail(std::string(own.status().message()));
      return queries;
    }
    queries.push_back(*std::move(own));
    return queries;
  }
  for (std::size_t k = 0; k < all->problems.size(); k += kProblemStep) {
    const std::string world = "problem_" + std::to_string(k);
    if (!PutPandaProblem(connection, all->problems[k], world).ok()) return {};
    std::vector<double> states = RandomStates(*all, all->problems[k], kBatch, k);
    queries.push_back(
        {PandaIn(world, states, v1::ROBOT_GEOMETRY_SPHERES_AS_GIVEN), std::move(states)});
  }
  return queries;
}

}  // namespace

void MeasurePython(Report& report) {
  const RunningServer server;
  if (!server.up()) return report.Fail("no server");
  const client::Connection& connection = server.connection();
  const testing::ScratchDirectory scratch;
  const std::vector<RobotQuery> queries = MakeQueries(connection, report);
  if (queries.empty()) return report.Fail("no world with a robot to ask about");
  std::vector<double> ratios, python_s, cpp_s;
  for (const RobotQuery& query : queries) {
    std::vector<double> python_rounds_s, cpp_rounds_s;
    for (int round = 0; round < kRounds; ++round) {
      std::string error;
      const auto cpp = EvaluateInCpp(connection.address(), query);
      const auto python = EvaluateInPython(connection, query, scratch, error);
      if (!cpp || !python) return report.Fail("a batch failed: " + error);
      if (cpp->collisions != python->collisions) {
        return report.Fail("the Python client tells other collisions than the C++ client");
      }
      cpp_rounds_s.push_back(cpp->batch_s);
      python_rounds_s.push_back(python->batch_s);
    }
    cpp_s.push_back(Median(cpp_rounds_s));
    python_s.push_back(Median(python_rounds_s));
    ratios.push_back(cpp_s.back() / python_s.back());
  }
  const double states_per_s = static_cast<double>(kBatch) / Median(python_s);
  char text[200];
  std::snprintf(text, sizeof(text), "Python client: %.0f states/s (%.2f ms a batch), C++ %.2f ms",
                states_per_s, 1e3 * Median(python_s), 1e3 * Median(cpp_s));
  report.Detail(text);
  report.Add({.key = "python_batch_ratio",
              .value = Median(ratios),
              .unit = "1",
              .how = "throughput of the Python client over that of the C++ client, both asking "
                     "unary batches of 10 000 states of the Panda's 59 spheres as given (without "
                     "the planning problems: of three balls) over the Unix socket, in turn; median "
                     "over a problem of each family"});
}

}  // namespace cwm::benchmarks
