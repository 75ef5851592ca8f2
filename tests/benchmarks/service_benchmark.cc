#include <grpcpp/grpcpp.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "clients/cpp/cloud_upload.h"
#include "clients/cpp/connection.h"
#include "collision/query/query.h"
#include "tests/benchmarks/benchmark_scans.h"
#include "tests/benchmarks/benchmark_world.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/running_server.h"

namespace cwm::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

double Seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

v1::PlacedShape GripperPart() {
  v1::PlacedShape part;
  part.mutable_box()->set_size_x_m(0.1);
  part.mutable_box()->set_size_y_m(0.08);
  part.mutable_box()->set_size_z_m(0.2);
  return part;
}

v1::GetDistancesRequest PartAt(const v1::PlacedShape& part, const std::vector<Pose>& poses) {
  v1::GetDistancesRequest request;
  v1::Subject::Shapes* shapes = request.mutable_subject()->mutable_shapes();
  *shapes->add_shapes() = part;
  std::vector<double> rows;
  for (const Pose& X : poses) {
    const Quaternion q(X.linear());
    rows.insert(rows.end(), {X.translation().x(), X.translation().y(), X.translation().z(), q.x(),
                             q.y(), q.z(), q.w()});
  }
  std::string* data = shapes->mutable_x_world_body()->mutable_data();
  data->resize(rows.size() * sizeof(double));
  std::memcpy(data->data(), rows.data(), data->size());
  return request;
}

v1::GetDistancesRequest GripperAt(const std::vector<Pose>& poses) {
  return PartAt(GripperPart(), poses);
}

struct StreamRate {
  double us_per_answer = 0;
  double answers_per_s = 0;
  bool ok = false;
};

// One batch in flight on one stream, for `seconds`.
StreamRate MeasureStream(const RunningServer& server, const v1::GetDistancesRequest& query,
                         int batch, double seconds) {
  const auto stub = &server.connection().queries();
  grpc::ClientContext context;
  const auto stream = stub->StreamQueries(&context);
  v1::StreamQueriesRequest request;
  *request.mutable_get_distances() = query;
  v1::StreamQueriesResponse response;
  std::vector<double> batch_us;
  const Clock::time_point start = Clock::now();
  while (Seconds(Clock::now() - start) < seconds) {
    const Clock::time_point sent = Clock::now();
    request.set_id(request.id() + 1);
    if (!stream->Write(request) || !stream->Read(&response) || response.has_error()) return {};
    if (response.get_distances().completed_count() != batch) return {};
    batch_us.push_back(Seconds(Clock::now() - sent) * 1e6);
  }
  stream->WritesDone();
  while (stream->Read(&response)) {
  }
  const double median_us = Median(batch_us);
  return {.us_per_answer = median_us / batch,
          .answers_per_s = 1e6 * batch / median_us,
          .ok = stream->Finish().ok()};
}

// gRPC's overhead is measured with queries that cost next to nothing: a ball against a world of one
// ball. Beside 30 objects the answers take ten times as long as their transport, and the difference
// of the two runs is lost in the noise of a shared core.
constexpr double kBallRadius_m = 0.05;
constexpr const char* kOneBallWorld = "one_ball";

bool PutOneBall(const RunningServer& server) {
  v1::ApplyChangesRequest request;
  request.set_world(kOneBallWorld);
  v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
  object->set_name("ball");
  object->mutable_x_world_object()->set_qw(1);
  object->add_shapes()->mutable_sphere()->set_radius_m(kBallRadius_m);
  grpc::ClientContext context;
  v1::ApplyChangesResponse response;
  return server.connection().worlds().ApplyChanges(&context, request, &response).ok();
}

v1::GetDistancesRequest BallAt(const std::vector<Pose>& poses) {
  v1::PlacedShape part;
  part.mutable_sphere()->set_radius_m(kBallRadius_m);
  v1::GetDistancesRequest request = PartAt(part, poses);
  request.set_world(kOneBallWorld);
  return request;
}

// The same query in process, median.
double BallInProcessMicroseconds(const std::vector<Pose>& poses, double seconds) {
  const Shape ball = Sphere{.radius_m = kBallRadius_m};
  auto model = std::make_shared<HybridModel>();
  model->shapes.emplace_back().shape = ball;
  std::vector<collision::Change> changes(1);
  collision::PutObject put;
  put.name = "ball";
  put.geometry = collision::Prepare(std::move(model));
  changes[0].what = std::move(put);
  const auto world =
      collision::Apply(std::make_shared<const collision::WorldSnapshot>(), changes).value();
  const collision::QueryBody body = collision::BodyFromShapes({{.shape = ball}});
  std::vector<double> batch_us;
  const Clock::time_point start = Clock::now();
  while (Seconds(Clock::now() - start) < seconds) {
    const Clock::time_point sent = Clock::now();
    if (!collision::GetDistances(*world, body, poses, {}).ok()) return std::nan("");
    batch_us.push_back(Seconds(Clock::now() - sent) * 1e6);
  }
  return Median(batch_us) / static_cast<double>(poses.size());
}

void MeasureTransport(const RunningServer& server, Report& report) {
  report.Detail(
      "Distances through gRPC (one stream over the Unix socket, one batch in flight, F64 "
      "columns):");
  for (const int batch : {1, 100, 10'000}) {
    const StreamRate rate = MeasureStream(server, GripperAt(RandomPoses(batch, 7)), batch, 1.0);
    char text[128];
    std::snprintf(text, sizeof(text), "  batch %-6d %12.0f answers/s %10.3f us per answer%s", batch,
                  rate.answers_per_s, rate.us_per_answer, rate.ok ? "" : "   FAILED");
    rate.ok ? report.Detail(text) : report.Fail(text);
  }
  if (!PutOneBall(server)) return report.Fail("no world for the transport");
  const std::vector<Pose> poses = RandomPoses(10'000, 7);
  std::vector<double> through, within;
  for (int round = 0; round < 5; ++round) {
    within.push_back(BallInProcessMicroseconds(poses, 0.5));
    const StreamRate rate = MeasureStream(server, BallAt(poses), 10'000, 0.5);
    if (!rate.ok || std::isnan(within.back()))
      return report.Fail("a batch of the transport failed");
    through.push_back(rate.us_per_answer);
  }
  report.Add({.key = "transport_us_per_distance",
              .value = Median(through) - Median(within),
              .unit = "us",
              .baseline = "same batch in process",
              .baseline_value = Median(within),
              .ratio = Median(through) / Median(within),
              .how = "StreamQueries minus in process, batches of 10 000 distances with points, "
                     "normal, object in F64, of a ball to a world of one ball; ratio is through "
                     "gRPC over in process"});
}

std::vector<double> QueryLatencies_ms(const RunningServer& server, const std::atomic<bool>& stop,
                                      double min_s) {
  const auto stub = &server.connection().queries();
  const v1::GetDistancesRequest request = GripperAt(RandomPoses(100, 11));
  std::vector<double> latencies;
  const Clock::time_point start = Clock::now();
  while (!stop || Seconds(Clock::now() - start) < min_s) {
    grpc::ClientContext context;
    v1::GetDistancesResponse response;
    const Clock::time_point sent = Clock::now();
    if (!stub->GetDistances(&context, request, &response).ok()) return {};  // empty on failure
    latencies.push_back(Seconds(Clock::now() - sent) * 1e3);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));  // a control loop, not a flood
  }
  return latencies;
}

void MeasureQueriesDuringIngest(const RunningServer& server, const BenchmarkScans& scans,
                                Report& report) {
  std::vector<double> idle, busy;
  for (int round = 0; round < 3; ++round) {
    std::atomic<bool> stop = true;
    const std::vector<double> quiet = QueryLatencies_ms(server, stop, 2.0);
    idle.insert(idle.end(), quiet.begin(), quiet.end());
    stop = false;
    std::vector<double> loud;
    std::thread querying([&] { loud = QueryLatencies_ms(server, stop, 0); });
    for (const formats::CloudFile& file : scans.files) {
      v1::IngestCloudHeader header;
      header.set_world("during_queries");
      if (!client::IngestCloud(server.connection(), header, file).ok())
        report.Fail("an ingest failed");
    }
    stop = true;
    querying.join();
    busy.insert(busy.end(), loud.begin(), loud.end());
    if (quiet.empty() || loud.empty()) return report.Fail("a query failed, idle or during ingests");
  }
  char text[200];
  std::snprintf(text, sizeof(text),
                "Unary queries of 100 distances every 2 ms: idle p50 %.2f ms p99 %.2f ms; during "
                "ingests p50 %.2f ms p99 %.2f ms",
                Median(idle), Quantile(idle, 0.99), Median(busy), Quantile(busy, 0.99));
  report.Detail(text);
  report.Add({.key = "query_p99_during_ingest_ratio",
              .value = Quantile(busy, 0.99) / Quantile(idle, 0.99),
              .unit = "1",
              .how = "p99 of unary batches of 100 distances while scans are ingested one after "
                     "another, over the idle p99; "
                     "client and server share the cores"});
}

void MeasureScan(const RunningServer& server, const BenchmarkScans& scans, Report& report) {
  std::vector<double> whole_ms, after_last_byte_ms;
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < scans.files.size(); ++i) {
      v1::IngestCloudHeader header;
      header.set_world("scan_" + std::to_string(round) + "_" + std::to_string(i));
      const Clock::time_point start = Clock::now();
      Clock::time_point last_byte = start;
      const auto reply =
          client::IngestCloud(server.connection(), header, scans.files[i],
                              [&](std::int64_t, std::int64_t) { last_byte = Clock::now(); });
      const Clock::time_point end = Clock::now();
      if (!reply.ok()) {
        report.Fail("an ingest failed: " + std::string(reply.status().message()));
        continue;
      }
      whole_ms.push_back(Seconds(end - start) * 1e3);
      after_last_byte_ms.push_back(Seconds(end - last_byte) * 1e3);
    }
  }
  char text[240];
  std::snprintf(text, sizeof(text),
                "IngestCloud of 640 x 480, new worlds: whole call median %.1f ms p95 %.1f ms; from "
                "the last byte sent "
                "median %.1f ms; server holds %.0f MiB afterwards",
                Median(whole_ms), Quantile(whole_ms, 0.95), Median(after_last_byte_ms),
                server.ResidentMebibytes());
  report.Detail(text);
  report.Add({.key = "scan_ms",
              .value = Median(whole_ms),
              .unit = "ms",
              .baseline = "",
              .baseline_value = std::nullopt,
              .ratio = std::nullopt,
              .how = "median of whole IngestCloud calls, upload included, until the world holds "
                     "the scan for every engine; " +
                     scans.source});
}

}  // namespace

void MeasureService(Report& report) {
  const RunningServer server;
  if (!server.up()) {
    report.Detail("the server did not come up: no figures of the service");
    return;
  }
  const BenchmarkScans scans = LoadBenchmarkScans();
  MeasureTransport(server, report);
  MeasureScan(server, scans, report);
  MeasureQueriesDuringIngest(server, scans, report);
}

}  // namespace cwm::benchmarks
