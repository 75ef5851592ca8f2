// cwm bench
#include <sched.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <optional>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "clients/cli/all_pages.h"
#include "clients/cli/bench/bench_queries.h"
#include "clients/cli/bench/bench_report.h"
#include "clients/cli/bench/interrupt_handler.h"
#include "clients/cli/bench/jobs.h"
#include "clients/cli/bench/measure.h"
#include "clients/cli/bench/temporary_world.h"
#include "clients/cli/commands.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/progress.h"
#include "clients/cli/quantity.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

constexpr double kMinSeconds = 0.05, kMaxSeconds = 600;
// chosen: above this load per core, other programs take time that is to be measured.
constexpr double kBusyLoad = 0.5;

struct BenchArguments {
  double seconds = 2;
  int batch = 1000;
  std::string robot;
  bool writes = false;
};

int UsableCores() {
  cpu_set_t usable;
  CPU_ZERO(&usable);
  return sched_getaffinity(0, sizeof(usable), &usable) == 0 ? std::max(1, CPU_COUNT(&usable)) : 1;
}

absl::Status ValidateArguments(const BenchArguments& arguments, const Session& session) {
  if (!(arguments.seconds >= kMinSeconds && arguments.seconds <= kMaxSeconds)) {
    return UsageError(absl::StrCat("--seconds is ", arguments.seconds, ", must be ", kMinSeconds,
                                   " to ", kMaxSeconds));
  }
  if (arguments.batch < 1) {
    return UsageError(absl::StrCat("--batch is ", arguments.batch, ", must be at least 1"));
  }
  if (arguments.writes && !(session.world.empty() && arguments.robot.empty())) {
    return UsageError(
        "--writes changes a world: only that of its own, which --world and --robot take the place "
        "of");
  }
  return absl::OkStatus();
}

// The region in which the world's objects are.
Region RegionOf(const pb::ListObjectsResponse& objects) {
  // chosen: a gripper's length around them, so that places beside them are included.
  constexpr double kPadding_m = 0.2;
  if (objects.objects().empty()) return kBenchRegion;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Region region{.min = {kFar, kFar, kFar}, .max = {-kFar, -kFar, -kFar}};
  for (const pb::Object& object : objects.objects()) {
    const pb::Pose& pose = object.x_world_object();
    const std::array<double, 3> at = {pose.tx_m(), pose.ty_m(), pose.tz_m()};
    for (std::size_t k = 0; k < at.size(); ++k) {
      region.min[k] = std::min(region.min[k], at[k] - kPadding_m);
      region.max[k] = std::max(region.max[k], at[k] + kPadding_m);
    }
  }
  return region;
}

struct Target {
  QueriedWorld world;
  std::optional<pb::Robot> robot;
};

// Reads the contents of an existing world.
absl::StatusOr<Target> ReadWorld(Session& session, const BenchArguments& arguments,
                                 BenchReport& report) {
  const client::Connection& connection = session.connection();
  pb::ListObjectsRequest objects_request;
  objects_request.set_world(session.world);
  objects_request.set_view(pb::OBJECT_VIEW_BASIC);
  const auto objects = ListAllPages<pb::ListObjectsResponse>(
      session, &pb::WorldService::Stub::ListObjects, connection.worlds(), objects_request);
  if (!objects.ok()) return objects.status();
  pb::ListRobotsRequest robots_request;
  robots_request.set_world(session.world);
  const auto robots = ListAllPages<pb::ListRobotsResponse>(
      session, &pb::RobotService::Stub::ListRobots, connection.robots(), robots_request);
  if (!robots.ok()) return robots.status();
  Target target;
  target.world.name = session.world;
  target.world.region = RegionOf(*objects);
  for (const pb::Robot& robot : robots->robots()) {
    if (robot.name() == arguments.robot) target.robot = robot;
  }
  report.world = session.world.empty() ? "default" : session.world;
  report.is_own_world = false;
  report.object_count = objects->objects_size();
  report.robot_count = robots->robots_size();
  if (arguments.robot.empty() || target.robot) return target;
  robots_request.set_name(arguments.robot);  // the server's error names the robot
  return connection.Call(&pb::RobotService::Stub::ListRobots, connection.robots(), robots_request)
      .status();
}

absl::Status RunJobs(Session& session, const std::vector<Job>& jobs, const MeasureOptions& options,
                     BenchReport& report) {
  Progress progress(session);
  double left_s = 0;
  for (const Job& job : jobs) left_s += DurationOf_s(job, options.seconds);
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const BenchLine& line = jobs[i].line;
    progress.ShowStage(absl::StrCat(i + 1, " of ", jobs.size(), ": ", line.name, ", ",
                                    line.rows_per_call, " ", line.unit, " a call, ", line.method,
                                    ", ", FormatFixed(std::ceil(left_s), 0), " s left"));
    const auto measured = RunJob(jobs[i], options);
    if (!measured.ok()) return measured.status();
    report.lines.push_back(*measured);
    left_s -= DurationOf_s(jobs[i], options.seconds);
  }
  return absl::OkStatus();
}

void PrintReport(const BenchReport& report, Session& session) {
  std::ostream& out = session.streams.out;
  switch (session.form) {
    case OutputForm::kTable:
      return PrintBench(report, session.table_style(), out);
    case OutputForm::kNdjson:
      for (const BenchLine& line : report.lines) out << BenchLineToJson(line).dump() << "\n";
      return;
    case OutputForm::kJson:
      out << BenchReportToJson(report).dump(1) << "\n";
  }
}

absl::StatusOr<BenchReport> StartReport(Session& session, const BenchArguments& arguments) {
  const client::Connection& connection = session.connection();
  const auto info = connection.Call(&pb::AdminService::Stub::GetServerInfo, connection.admin(),
                                    pb::GetServerInfoRequest());
  if (!info.ok()) return info.status();
  if (arguments.batch > info->limits().max_batch_rows()) {
    return UsageError(absl::StrCat("--batch is ", arguments.batch, ", must be at most ",
                                   info->limits().max_batch_rows(), ", the server's limit"));
  }
  BenchReport report;
  report.address = connection.address();
  report.server = *info;
  report.client_version = CWM_VERSION;
  report.cores = UsableCores();
  double load = 0;
  if (::getloadavg(&load, 1) == 1) report.load = load;
  if (report.load && *report.load > kBusyLoad * report.cores) {
    session.Warn(absl::StrCat("other programs are busy (load ", FormatFixed(*report.load, 1),
                              " on ", report.cores, report.cores == 1 ? " core" : " cores",
                              "): an idle machine is faster than what follows"));
  }
  return report;
}

// Removes the benchmark's world, or warns how to remove it.
void RemoveOrWarn(TemporaryWorld& own, Session& session) {
  const absl::Status removed = own.Remove();
  if (removed.ok()) return;
  session.Warn(absl::StrCat("the world ", own.name(), " may still be there (",
                            std::string(removed.message()),
                            "): cwm call DeleteWorld '{\"world\": \"", own.name(), "\"}'"));
}

absl::Status Bench(Session& session, const BenchArguments& arguments) {
  if (absl::Status status = ValidateArguments(arguments, session); !status.ok()) return status;
  auto report = StartReport(session, arguments);
  if (!report.ok()) return report.status();
  const client::Connection& connection = session.connection();
  const InterruptHandler interrupts;  // from before the world exists until it is removed
  std::unique_ptr<TemporaryWorld> own, scanned;
  Target target;
  if (session.world.empty() && arguments.robot.empty()) {
    const std::vector<pb::Change> scene = BenchScene();
    auto made = TemporaryWorld::Make(connection, TemporaryWorldName(), scene);
    if (!made.ok()) return made.status();
    own = *std::move(made);
    target.world.name = own->name();
    report->world = own->name();
    report->object_count = static_cast<std::int64_t>(scene.size());
  } else {
    auto read = ReadWorld(session, arguments, *report);
    if (!read.ok()) return read.status();
    target = *std::move(read);
  }
  client::QueryStream stream(connection);
  std::vector<Job> jobs;
  const auto add = [&](BenchQuery (*make_query)(const QueriedWorld&, int), int rows) {
    AddQuery(
        connection, stream, target.world,
        [make_query, rows](const QueriedWorld& world) { return make_query(world, rows); }, jobs);
  };
  add(Distances, 1);
  add(BodyChecks, arguments.batch);
  add(Distances, arguments.batch);
  add(SampledPoints, arguments.batch);
  if (target.robot) {
    AddQuery(
        connection, stream, target.world,
        [&](const QueriedWorld& world) {
          return RobotStates(world, *target.robot, arguments.batch);
        },
        jobs);
  }
  if (arguments.writes) {
    auto made = TemporaryWorld::Make(connection, own->name() + "-scans", {BenchScene().front()});
    if (!made.ok()) return made.status();
    scanned = *std::move(made);
    AddMoves(connection, own->name(), BenchScene().front().put().object().name(), jobs);
    AddIngests(connection, scanned->name(), jobs);
  }
  const absl::Status measured = RunJobs(
      session, jobs,
      {.seconds = arguments.seconds, .stopped = [&] { return interrupts.signalled(); }}, *report);
  for (TemporaryWorld* world : {own.get(), scanned.get()}) {
    if (world != nullptr) RemoveOrWarn(*world, session);
  }
  if (measured.ok() || !report->lines.empty()) PrintReport(*report, session);
  return measured;
}

}  // namespace

void AddBenchCommand(CommandLine& line) {
  const auto arguments = std::make_shared<BenchArguments>();
  CLI::App& command = AddCommand(
      line,
      {"bench",
       "how fast the server answers here: latency, rows a second, and what limits them",
       {"cwm bench", "cwm bench --seconds 5 --batch 10000 -o json",
        "cwm bench --addr localhost:50051", "cwm bench --world kitchen --robot panda",
        "cwm bench --writes"},
       "Asks a world of its own, 30 shapes within 1 m, which it makes under a new name and removes "
       "again,\n"
       "after Ctrl-C as well; no other world is read or changed. With --world or --robot that "
       "world "
       "is asked\n"
       "as it is, and nothing is written. Each measurement warms up for a tenth of --seconds, then "
       "takes\n"
       "5 stretches of a fifth: a rate is the median of them, SPREAD how far they lie apart, p50 "
       "and p99 are\n"
       "of all calls (p99 of at least 100). One call is under way at a time: more clients may get "
       "more out of\n"
       "the server. ANSWERING is the share of the time that is saved by asking the same "
       "1 km above, where\n"
       "nothing is: what the server works on its answers. Times are this client's, and include its "
       "own work and the way there."},
      [arguments](Session& session) { return Bench(session, *arguments); });
  command.add_option("--seconds", arguments->seconds, "of each measurement; default 2")
      ->type_name("S");
  command.add_option("--batch", arguments->batch, "rows in a call; default 1000")->type_name("N");
  command
      .add_option("--robot", arguments->robot,
                  "measure states of this robot too, random within its limits")
      ->type_name("NAME");
  command.add_flag("--writes", arguments->writes,
                   "measure changes and scans too, in worlds of its own");
}

}  // namespace cwm::cli
