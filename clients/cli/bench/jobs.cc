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
constexpr double kEmptySpaceShare = 0.5;

}  // namespace

void AddQuery(const client::Connection& connection, client::QueryStream& stream,
              const QueriedWorld& world,
              const std::function<BenchQuery(const QueriedWorld&)>& make_query,
              std::vector<Job>& jobs) {
  const auto query = std::make_shared<BenchQuery>(make_query(world));
  BenchLine line{
      .name = query->name, .method = "unary", .unit = "rows", .rows_per_call = query->rows};
  jobs.push_back(
      {.line = line, .call = [&connection, query] { return CallUnary(connection, *query); }});
  const auto in_empty_space = std::make_shared<BenchQuery>(InEmptySpace(world, make_query));
  line.method = "stream";
  jobs.push_back({.line = line,
                  .call = [&stream, query] { return CallStream(stream, *query); },
                  .empty_space_call =
                      [&stream, in_empty_space] { return CallStream(stream, *in_empty_space); }});
}

void AddMoves(const client::Connection& connection, const std::string& world,
              const std::string& object, std::vector<Job>& jobs) {
  const auto moved = std::make_shared<pb::ApplyChangesRequest>();
  moved->set_world(world);
  pb::MoveObject& move = *moved->add_changes()->mutable_move();
  move.set_name(object);
  move.mutable_x_world_object()->set_qw(1);
  jobs.push_back(
      {.line = {.name = "changes", .method = "unary", .unit = "changes", .rows_per_call = 1},
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
  jobs.push_back({.line = {.name = "scans",
                           .method = "upload",
                           .unit = "points",
                           .rows_per_call = scan->size()},
                  .call = [&connection, scan, header] {
                    return client::IngestCloud(connection, header, *scan).status();
                  }});
}

double DurationOf_s(const Job& job, double seconds) {
  constexpr double kWithWarmUp = 1.1;
  return kWithWarmUp * seconds * (job.empty_space_call ? 1 + kEmptySpaceShare : 1);
}

absl::StatusOr<BenchLine> RunJob(const Job& job, MeasureOptions options) {
  options.rows_per_call = job.line.rows_per_call;
  const auto measured = Measure(job.call, options);
  if (!measured.ok()) return measured.status();
  BenchLine line = job.line;
  line.measured = *measured;
  if (!job.empty_space_call) return line;
  options.seconds *= kEmptySpaceShare;
  const auto in_empty_space = Measure(job.empty_space_call, options);
  if (!in_empty_space.ok()) return in_empty_space.status();
  line.work_share = std::max(0.0, 1 - in_empty_space->p50_ms / measured->p50_ms);
  return line;
}

}  // namespace cwm::cli
