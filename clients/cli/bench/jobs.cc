#include "clients/cli/bench/jobs.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "clients/cli/bench/scan.h"
#include "clients/cpp/cloud_upload.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

// chosen: the share of measuring time for the same query in empty space, of which only the median
// is needed.
constexpr double kShareOfNothing = 0.5;

}  // namespace

void AddQuestion(const client::Connection& connection, client::QueryStream& stream,
                 const AskedWorld& world, const std::function<Question(const AskedWorld&)>& ask,
                 std::vector<Job>& jobs) {
  const auto asked = std::make_shared<Question>(ask(world));
  BenchLine line{.of = asked->of, .through = "unary", .unit = "rows", .rows_per_call = asked->rows};
  jobs.push_back(
      {.line = line, .call = [&connection, asked] { return AskUnary(connection, *asked); }});
  const auto of_nothing = std::make_shared<Question>(OfNothing(world, ask));
  line.through = "stream";
  jobs.push_back(
      {.line = line,
       .call = [&stream, asked] { return AskStream(stream, *asked); },
       .call_of_nothing = [&stream, of_nothing] { return AskStream(stream, *of_nothing); }});
}

void AddMoves(const client::Connection& connection, const std::string& world,
              const std::string& object, std::vector<Job>& jobs) {
  const auto moved = std::make_shared<pb::ApplyChangesRequest>();
  moved->set_world(world);
  pb::MoveObject& move = *moved->add_changes()->mutable_move();
  move.set_name(object);
  move.mutable_x_world_object()->set_qw(1);
  jobs.push_back(
      {.line = {.of = "changes", .through = "unary", .unit = "changes", .rows_per_call = 1},
       .call = [&connection, moved] {
         pb::Pose& pose = *moved->mutable_changes(0)->mutable_move()->mutable_x_world_object();
         pose.set_tx_m(pose.tx_m() == 0 ? 0.1 : 0);
         return connection.Call(&pb::WorldService::Stub::ApplyChanges, connection.worlds(), *moved)
             .status();
       }});
}

void AddIngests(const client::Connection& connection, const std::string& world,
                std::vector<Job>& jobs) {
  const auto scan = std::make_shared<formats::CloudFile>(BenchScan());
  pb::IngestCloudHeader header;
  header.set_world(world);
  jobs.push_back({.line = {.of = "scans",
                           .through = "upload",
                           .unit = "points",
                           .rows_per_call = scan->size()},
                  .call = [&connection, scan, header] {
                    return client::IngestCloud(connection, header, *scan).status();
                  }});
}

double SecondsOf(const Job& job, double seconds) {
  constexpr double kWithWarmUp = 1.1;
  return kWithWarmUp * seconds * (job.call_of_nothing ? 1 + kShareOfNothing : 1);
}

absl::StatusOr<BenchLine> Run(const Job& job, MeasureOptions options) {
  options.rows_per_call = job.line.rows_per_call;
  const auto measured = Measure(job.call, options);
  if (!measured.ok()) return measured.status();
  BenchLine line = job.line;
  line.measured = *measured;
  if (!job.call_of_nothing) return line;
  options.seconds *= kShareOfNothing;
  const auto of_nothing = Measure(job.call_of_nothing, options);
  if (!of_nothing.ok()) return of_nothing.status();
  line.work_share = std::max(0.0, 1 - of_nothing->p50_ms / measured->p50_ms);
  return line;
}

}  // namespace cwm::cli
