#include <grpcpp/grpcpp.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "collision/query/query.h"
#include "cwm/v1/perception.grpc.pb.h"
#include "cwm/v1/query.grpc.pb.h"
#include "cwm/v1/world.grpc.pb.h"
#include "tests/benchmarks/benchmark_scans.h"
#include "tests/benchmarks/benchmark_world.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/cloud_upload.h"
#include "tests/support/process.h"

namespace cwm::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

double Seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

// A server of its own, the benchmark world in its world "default".
class RunningServer {
 public:
  explicit RunningServer(const std::string& program)
      : address_("unix:" + scratch_ / "cwm.sock"),
        process_({program, "--listen", address_}, scratch_ / "server.log") {
    grpc::ChannelArguments arguments;
    arguments.SetMaxReceiveMessageSize(16 << 20);
    channel_ = grpc::CreateCustomChannel(address_, grpc::InsecureChannelCredentials(), arguments);
    up_ = channel_->WaitForConnected(std::chrono::system_clock::now() + std::chrono::seconds(10));
    if (up_) up_ = PutBenchmarkWorld();
  }

  bool up() const { return up_; }
  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }
  double ResidentMebibytes() const { return process_.ResidentMebibytes(); }

 private:
  static void SetPose(const Pose& X, v1::Pose* out) {
    const Quaternion q(X.linear());
    out->set_tx_m(X.translation().x());
    out->set_ty_m(X.translation().y());
    out->set_tz_m(X.translation().z());
    out->set_qx(q.x());
    out->set_qy(q.y());
    out->set_qz(q.z());
    out->set_qw(q.w());
  }

  static void SetShape(const Shape& shape, v1::ShapePart* part) {
    if (const auto* box = std::get_if<Box>(&shape)) {
      part->mutable_box()->set_size_x_m(box->size_m.x());
      part->mutable_box()->set_size_y_m(box->size_m.y());
      part->mutable_box()->set_size_z_m(box->size_m.z());
    } else if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
      part->mutable_cylinder()->set_radius_m(cylinder->radius_m);
      part->mutable_cylinder()->set_length_m(cylinder->length_m);
    } else if (const auto* sphere = std::get_if<Sphere>(&shape)) {
      part->mutable_sphere()->set_radius_m(sphere->radius_m);
    } else if (const auto* capsule = std::get_if<Capsule>(&shape)) {
      part->mutable_capsule()->set_radius_m(capsule->radius_m);
      part->mutable_capsule()->set_length_m(capsule->length_m);
    }
  }

  bool PutBenchmarkWorld() {
    v1::ApplyChangesRequest request;
    for (const Placed<>& placed : BenchmarkShapes()) {
      v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
      object->set_name("object_" + std::to_string(request.changes_size() - 1));
      SetPose(placed.X_FS, object->mutable_x_world_object());
      SetShape(placed.shape, object->add_shapes());
    }
    grpc::ClientContext context;
    v1::ApplyChangesResponse response;
    return v1::WorldService::NewStub(channel_)->ApplyChanges(&context, request, &response).ok();
  }

  testing::ScratchDirectory scratch_;
  std::string address_;
  testing::Background process_;
  std::shared_ptr<grpc::Channel> channel_;
  bool up_ = false;
};

v1::GetDistancesRequest GripperAt(const std::vector<Pose>& poses) {
  v1::GetDistancesRequest request;
  v1::Subject::Shapes* shapes = request.mutable_subject()->mutable_shapes();
  v1::Box* box = shapes->add_shapes()->mutable_box();
  box->set_size_x_m(0.1);
  box->set_size_y_m(0.08);
  box->set_size_z_m(0.2);
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

struct StreamRate {
  double us_per_answer = 0;
  double answers_per_s = 0;
  bool ok = false;
};

// One batch in flight on one stream, for a second.
StreamRate MeasureStream(const RunningServer& server, int batch, double seconds) {
  const auto stub = v1::QueryService::NewStub(server.channel());
  grpc::ClientContext context;
  const auto stream = stub->StreamQueries(&context);
  v1::StreamQueriesRequest request;
  *request.mutable_get_distances() = GripperAt(RandomPoses(batch, 7));
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

// The same batch in process, median.
double InProcessMicrosecondsPerAnswer(int batch, double seconds) {
  const auto world = MakeBenchmarkWorld();
  const collision::QueryBody gripper =
      collision::BodyFromShapes({{.shape = Box{.size_m = {0.1, 0.08, 0.2}}}});
  const std::vector<Pose> poses = RandomPoses(batch, 7);
  std::vector<double> batch_us;
  const Clock::time_point start = Clock::now();
  while (Seconds(Clock::now() - start) < seconds) {
    const Clock::time_point sent = Clock::now();
    if (!collision::GetDistances(*world, gripper, poses, {}).ok()) return 0;
    batch_us.push_back(Seconds(Clock::now() - sent) * 1e6);
  }
  return Median(batch_us) / batch;
}

void MeasureTransport(const RunningServer& server, Report& report) {
  report.Detail(
      "Distances through gRPC (one stream over the Unix socket, one batch in flight, F64 "
      "columns):");
  for (const int batch : {1, 100, 10'000}) {
    const StreamRate rate = MeasureStream(server, batch, 1.0);
    char text[128];
    std::snprintf(text, sizeof(text), "  batch %-6d %12.0f answers/s %10.3f us per answer%s", batch,
                  rate.answers_per_s, rate.us_per_answer, rate.ok ? "" : "   FAILED");
    report.Detail(text);
  }
  std::vector<double> through, within;
  for (int round = 0; round < 5; ++round) {
    within.push_back(InProcessMicrosecondsPerAnswer(10'000, 0.5));
    through.push_back(MeasureStream(server, 10'000, 0.5).us_per_answer);
  }
  report.Add({.key = "transport_us_per_distance",
              .value = Median(through) - Median(within),
              .unit = "us",
              .rival = "same batch in process",
              .rival_value = Median(within),
              .ratio = Median(through) / Median(within),
              .how = "StreamQueries minus in process, batches of 10 000 distances with points, "
                     "normal, object; "
                     "ratio is through gRPC over in process"});
}

std::vector<double> QueryLatencies_ms(const RunningServer& server, const std::atomic<bool>& stop,
                                      double at_least_s) {
  const auto stub = v1::QueryService::NewStub(server.channel());
  const v1::GetDistancesRequest request = GripperAt(RandomPoses(100, 11));
  std::vector<double> latencies;
  const Clock::time_point start = Clock::now();
  while (!stop || Seconds(Clock::now() - start) < at_least_s) {
    grpc::ClientContext context;
    v1::GetDistancesResponse response;
    const Clock::time_point sent = Clock::now();
    if (!stub->GetDistances(&context, request, &response).ok()) return {};
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
    std::thread asking([&] { loud = QueryLatencies_ms(server, stop, 0); });
    for (const perception::PointCloud& cloud : scans.clouds) {
      UploadCloud(server.channel(), cloud, "during_queries");
    }
    stop = true;
    asking.join();
    busy.insert(busy.end(), loud.begin(), loud.end());
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
              .rival = "idle p99, ms",
              .rival_value = Quantile(idle, 0.99),
              .ratio = std::nullopt,
              .how = "p99 of unary batches of 100 distances while scans are ingested one after "
                     "another, over the idle p99; "
                     "client and server share the cores"});
}

void MeasureScan(const RunningServer& server, const BenchmarkScans& scans, Report& report) {
  std::vector<double> whole_ms, after_last_byte_ms;
  for (int round = 0; round < 3; ++round) {
    int number = 0;
    for (const perception::PointCloud& cloud : scans.clouds) {
      const UploadTimes times =
          UploadCloud(server.channel(), cloud,
                      "scan_" + std::to_string(round) + "_" + std::to_string(number++));
      if (!times.ok) {
        report.Detail("an ingest failed: " + times.error);
        continue;
      }
      whole_ms.push_back(times.whole_ms);
      after_last_byte_ms.push_back(times.after_last_byte_ms);
    }
  }
  char text[200];
  std::snprintf(text, sizeof(text),
                "IngestCloud of 640 x 480, new worlds: whole call median %.1f ms p95 %.1f ms; from "
                "the last byte in %.1f ms; "
                "server holds %.0f MiB afterwards",
                Median(whole_ms), Quantile(whole_ms, 0.95), Median(after_last_byte_ms),
                server.ResidentMebibytes());
  report.Detail(text);
  report.Add({.key = "scan_ms",
              .value = Median(whole_ms),
              .unit = "ms",
              .rival = "",
              .rival_value = std::nullopt,
              .ratio = std::nullopt,
              .how = "median of whole IngestCloud calls, upload included, until the world holds "
                     "the scan for every engine; " +
                     scans.source});
}

}  // namespace

void MeasureService(Report& report) {
  const RunningServer server(ServerProgram());
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
