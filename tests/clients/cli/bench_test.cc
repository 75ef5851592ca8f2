// The measurements and the output of `cwm bench`, without a server.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <cstring>
#include <sstream>
#include <thread>

#include "clients/cli/bench/bench_poses.h"
#include "clients/cli/bench/bench_queries.h"
#include "clients/cli/bench/bench_report.h"
#include "clients/cli/bench/interrupt_handler.h"
#include "clients/cli/bench/measure.h"
#include "clients/cli/bench/scan.h"
#include "clients/cli/bench/temporary_world.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<double> OneTo(int last) {
  std::vector<double> values;
  for (int i = last; i >= 1; --i) values.push_back(i);  // not in order
  return values;
}

TEST(Quantile, IsTheNearestRank) {
  EXPECT_EQ(Quantile(OneTo(100), 0.5), 50);
  EXPECT_EQ(Quantile(OneTo(100), 0.99), 99);
  EXPECT_EQ(Quantile(OneTo(101), 0.5), 51);
  EXPECT_EQ(Quantile(OneTo(3), 0.99), 3);
  EXPECT_EQ(Quantile({7}, 0.5), 7);
}

TEST(Summarize, TakesTheMedianStretchAndTheTimesOfAllCalls) {
  // Ten rows per call: 100, 20 (another program was busy) and 200 rows per second.
  const Measurement measured = Summarize({{.call_s = {0.1, 0.1}, .elapsed_s = 0.2},
                                          {.call_s = {0.5}, .elapsed_s = 0.5},
                                          {.call_s = {0.05, 0.05}, .elapsed_s = 0.1}},
                                         10);
  EXPECT_EQ(measured.calls, 5);
  EXPECT_DOUBLE_EQ(measured.elapsed_s, 0.8);
  EXPECT_DOUBLE_EQ(measured.rows_per_s, 100);
  EXPECT_DOUBLE_EQ(measured.min_rows_per_s, 20);
  EXPECT_DOUBLE_EQ(measured.max_rows_per_s, 200);
  EXPECT_DOUBLE_EQ(measured.p50_ms, 100);
  EXPECT_FALSE(measured.p99_ms) << "5 calls have no slowest in a hundred";
}

TEST(Summarize, TellsTheSlowestInAHundredOfAHundredCalls) {
  std::vector<double> calls(99, 0.001);
  EXPECT_FALSE(Summarize({{.call_s = calls, .elapsed_s = 1}}, 1).p99_ms);
  calls.push_back(5);
  EXPECT_DOUBLE_EQ(Summarize({{.call_s = calls, .elapsed_s = 1}}, 1).p99_ms.value(), 1);
}

TEST(Measure, CountsOnlyWhatComesAfterTheWarmUp) {
  int calls = 0;
  const auto measured = Measure(
      [&] {
        ++calls;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return absl::OkStatus();
      },
      {.seconds = 0.1, .rows_per_call = 7});
  ASSERT_TRUE(measured.ok()) << measured.status();
  EXPECT_LT(measured->calls, calls);
  EXPECT_GE(measured->calls, kRepetitions);
  EXPECT_GE(measured->elapsed_s, 0.1);
  EXPECT_GE(measured->p50_ms, 1);
  EXPECT_LE(measured->rows_per_s, 7 * 1000);
  EXPECT_LT(measured->client_cpu, 1) << "it slept most of the time";
}

TEST(Measure, EndsWithTheFirstErrorAndWhenItIsStopped) {
  int calls = 0;
  const auto failed =
      Measure([&] { return ++calls < 3 ? absl::OkStatus() : absl::NotFoundError("gone"); },
              {.seconds = 60});
  EXPECT_EQ(failed.status(), absl::NotFoundError("gone"));
  EXPECT_EQ(calls, 3);
  const auto stopped = Measure([&] { return ++calls, absl::OkStatus(); },
                               {.seconds = 60, .stopped = [&] { return calls >= 10; }});
  EXPECT_TRUE(absl::IsCancelled(stopped.status()));
  EXPECT_EQ(calls, 10);
}

TEST(InterruptHandler, RecordsTheFirstSignalAndRestoresThePreviousHandler) {
  static volatile std::sig_atomic_t seen = 0;
  const auto before = std::signal(SIGINT, [](int) { seen = seen + 1; });
  {
    const InterruptHandler interrupts;
    EXPECT_FALSE(interrupts.signalled());
    std::raise(SIGINT);
    EXPECT_TRUE(interrupts.signalled());
    EXPECT_EQ(seen, 0);
  }
  std::raise(SIGINT);
  EXPECT_EQ(seen, 1);
  EXPECT_FALSE(InterruptHandler().signalled()) << "each begins anew";
  std::signal(SIGINT, before);
}

TEST(Random, DrawsTheSameEverywhereWithinTheRegion) {
  Random random(42), again(42);
  // The first number of mt19937_64 with seed 42, which the standard defines, is
  // 13930160852258120406.
  EXPECT_EQ(random.Uniform(0, 1), static_cast<double>(13930160852258120406ULL >> 11) * 0x1p-53);
  again.Uniform(0, 1);
  for (int i = 0; i < 1000; ++i) {
    const client::PoseRow pose = random.RandomPose(kBenchRegion);
    EXPECT_EQ(pose, again.RandomPose(kBenchRegion));
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_GE(pose[k], kBenchRegion.min[k]);
      EXPECT_LE(pose[k], kBenchRegion.max[k]);
    }
    EXPECT_NEAR(std::hypot(std::hypot(pose[3], pose[4]), std::hypot(pose[5], pose[6])), 1, 1e-14);
  }
}

TEST(TemporaryWorldName, IsNewEachTime) {
  EXPECT_THAT(TemporaryWorldName(), ::testing::MatchesRegex("cwm-bench-[0-9]+-[0-9a-f]{8}"));
  EXPECT_NE(TemporaryWorldName(), TemporaryWorldName());
}

TEST(BenchQueries, HaveTheRowsThatTheySay) {
  const QueriedWorld world{.name = "kitchen"};
  const BenchQuery checks = BodyChecks(world, 5);
  EXPECT_EQ(checks.request.check_collisions().world(), "kitchen");
  EXPECT_EQ(checks.request.check_collisions().subject().shapes().x_world_body().data().size(),
            sizeof(double) * 5 * 7);
  const BenchQuery points = SampledPoints(world, 5);
  EXPECT_EQ(points.request.sample_points().points().data().size(), sizeof(double) * 5 * 3);
}

TEST(BenchQueries, DrawStatesWithinTheLimitsOfARobot) {
  pb::Robot robot;
  robot.set_name("arm");
  pb::RobotVariable& narrow = *robot.add_variables();
  narrow.set_joint_kind(pb::JOINT_KIND_REVOLUTE);
  narrow.set_lower(0.2);
  narrow.set_upper(0.3);
  robot.add_variables()->set_joint_kind(pb::JOINT_KIND_CONTINUOUS);
  robot.add_variables()->set_joint_kind(pb::JOINT_KIND_FLOATING);
  for (const double value : {0.25, 0.0, 0.6}) robot.add_state(value);
  constexpr std::size_t kRows = 100;
  const BenchQuery states = RobotStates({.name = "w"}, robot, static_cast<int>(kRows));
  const std::string& data = states.request.check_collisions().subject().robot().rows().data();
  std::array<double, kRows* 3> numbers = {};
  ASSERT_EQ(data.size(), sizeof(numbers));
  std::memcpy(numbers.data(), data.data(), sizeof(numbers));
  for (std::size_t row = 0; row < kRows; ++row) {
    EXPECT_GE(numbers[3 * row], 0.2);
    EXPECT_LE(numbers[3 * row], 0.3);
    EXPECT_LE(std::abs(numbers[3 * row + 1]), 3.1416);
    EXPECT_EQ(numbers[3 * row + 2], 0.6) << "what floats stays";
  }
}

TEST(BenchScan, SeesTheTableAndTheFloorBehindIt) {
  const formats::CloudFile cloud = BenchScan();
  ASSERT_EQ(cloud.size(), 640 * 480);
  ASSERT_EQ(cloud.bytes.size(), cloud.point_step * 640 * 480);
  constexpr std::size_t kMiddle = 240 * 640 + 320;
  std::array<float, 3> middle = {};
  std::memcpy(middle.data(), &cloud.bytes[cloud.point_step * kMiddle], sizeof(middle));
  // The camera is 0.7 m beside and 0.8 m above the middle of the table; the noise there is 0.002 m.
  EXPECT_NEAR(middle[2], std::hypot(0.7, 0.8), 5 * 0.002);
  std::array<float, 3> top = {};
  std::memcpy(top.data(), &cloud.bytes[cloud.point_step * 320], sizeof(top));
  EXPECT_GT(top[2], 1.5) << "above the table's far edge is floor";
}

BenchReport SomeReport() {
  BenchReport report;
  report.address = "unix:/tmp/x.sock";
  report.server.set_version("1.2.3");
  report.client_version = "1.2.4";
  report.cores = 2;
  report.world = "cwm-bench-1";
  report.object_count = 30;
  BenchLine line{.name = "distances", .method = "unary", .unit = "rows", .rows_per_call = 1000};
  line.measured = Summarize({{.call_s = {0.004}, .elapsed_s = 0.004}}, 1000);
  report.lines.push_back(line);
  line.method = "stream";
  line.work_share = 0.75;
  line.measured.client_cpu = 0.2;
  report.lines.push_back(line);
  return report;
}

TEST(BenchReport, SaysWhereHowFastAndWhatLimitsIt) {
  std::ostringstream out;
  PrintBench(SomeReport(), TableStyle::kPlain, out);
  EXPECT_THAT(out.str(), AllOf(HasSubstr("unix:/tmp/x.sock (Unix socket), version 1.2.3"),
                               HasSubstr("2 cores"), HasSubstr("removed again: 30 shapes"),
                               HasSubstr("250 000 rows"), HasSubstr("4.00"),
                               HasSubstr("distances 75 %"), HasSubstr("up to 20 % of one core")));
  EXPECT_THAT(out.str(), Not(HasSubstr("p99"))) << "one call has none: the column is left out";
}

TEST(BenchReport, KnowsNothingOfTheCoresOfAnotherMachine) {
  BenchReport report = SomeReport();
  report.address = "robot.local:50051";
  std::ostringstream out;
  PrintBench(report, TableStyle::kPlain, out);
  EXPECT_THAT(out.str(), HasSubstr("those of the server are not known"));
  EXPECT_EQ(TransportOf("robot.local:50051"), "TCP");
  EXPECT_EQ(TransportOf("127.0.0.1:50051"), "TCP over loopback");
}

TEST(BenchReport, HasTheSameInJson) {
  const auto json = BenchReportToJson(SomeReport());
  EXPECT_EQ(json.at("transport"), "Unix socket");
  EXPECT_EQ(json.at("measurements").size(), 2u);
  EXPECT_EQ(json.at("measurements")[0].at("rows_per_s"), 250'000);
  EXPECT_FALSE(json.at("measurements")[0].contains("p99_ms")) << "unknown is absent";
  EXPECT_FALSE(json.at("measurements")[0].contains("work_share"));
  EXPECT_EQ(json.at("measurements")[1].at("work_share"), 0.75);
}

}  // namespace
}  // namespace cwm::cli
