#include "tests/benchmarks/server/overload_clients.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>

#include "absl/strings/str_cat.h"
#include "clients/cpp/call_error.h"
#include "tests/benchmarks/benchmark_scans.h"
#include "tests/benchmarks/server/hostile_content.h"

namespace cwm::benchmarks {
namespace {

constexpr int kBatchConnections = 3, kBatchesInFlight = 8;  // of each
constexpr int kScanConnections = 2;
constexpr int kHostileClients = 3;
constexpr double kCallLimit_s = 30;

// The requests of the attackers: memory without a budget, and work that blocks others.
const std::vector<std::string>& HostileNames() {
  static const std::vector<std::string> names = {
      "LoadRobot/collada_two_scales",  "CheckCollisions/hull_mentions",
      "StreamQueries/overlay_spheres", "ApplyChanges/mesh_mentions",
      "ExportWorld/glb_unread",        "GetDistances/at_least",
      "GetContacts/mesh_mentions",     "LoadRobot/half_open",
      "CheckCollisions/mesh_mentions", "ApplyChanges/tiny_spheres"};
  return names;
}

// A hostile request with the content that it needs on the server, one copy per client.
struct Armed {
  HostileRequest request;
  std::unique_ptr<Target> target;
};

std::vector<std::vector<float>> ScanPoints() {
  std::vector<std::vector<float>> clouds;
  for (const perception::PointCloud& cloud : LoadBenchmarkScans().clouds) {
    std::vector<float>& xyz = clouds.emplace_back();
    for (const auto& point : cloud.points) xyz.insert(xyz.end(), {point.x(), point.y(), point.z()});
    if (clouds.size() == 2) break;
  }
  return clouds;
}

}  // namespace

void Clients::Add(std::function<void()> once) {
  threads_.emplace_back([this, once = std::move(once)] {
    while (!over_) once();
  });
}

void Clients::End() {
  over_ = true;
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void CallWithRetry(const std::shared_ptr<grpc::Channel>& channel, const CallPlan& plan,
                   const std::atomic<bool>& over, Tally& tally) {
  constexpr auto kSlice = std::chrono::milliseconds(50);
  const auto start = SteadyClock::now();
  double first_advice_s = 0, first_refusal_s = 0;
  int refusals = 0;
  while (SecondsSince(start) < kCallLimit_s && !over) {
    const auto sent = SteadyClock::now();
    const double sent_s = SecondsSince(start);
    HeldCall call(channel, plan);
    while (!call.WaitUntilDone(kSlice) && !over && SecondsSince(start) < kCallLimit_s) {
    }
    if (over) return;
    const grpc::Status status = call.status();
    const bool done = call.Outcome() != "open";
    const client::ErrorDetails details = client::DetailsOf(client::StatusFromGrpc(status));
    std::unique_lock lock(tally.mutex);
    if (done && status.ok()) {
      tally.latencies_s.push_back(SecondsSince(sent));
      if (refusals == 0) return;
      tally.advised_s.push_back(first_advice_s);
      tally.actual_s.push_back(sent_s - first_refusal_s);
      return;
    }
    if (!done || status.error_code() != grpc::StatusCode::RESOURCE_EXHAUSTED ||
        !details.retry_after_s) {
      ++tally.failed;
      if (tally.failure.empty()) tally.failure = call.Outcome() + ": " + status.error_message();
      break;
    }
    ++tally.refused;
    if (refusals++ == 0) {
      first_advice_s = *details.retry_after_s;
      first_refusal_s = sent_s;
    }
    const double pause_s = std::clamp(*details.retry_after_s, 0.001, 5.0);
    lock.unlock();
    std::this_thread::sleep_for(std::chrono::duration<double>(pause_s));
  }
}

CallPlan BatchPlan() {
  v1::GetDistancesRequest request;
  request.set_world("small");
  for (int i = 0; i < 4; ++i) {
    v1::PlacedShape* part = request.mutable_subject()->mutable_shapes()->add_shapes();
    part->mutable_x_body_shape()->set_tz_m(0.1 * i);
    part->mutable_x_body_shape()->set_qw(1);
    part->mutable_cylinder()->set_radius_m(0.03);
    part->mutable_cylinder()->set_length_m(0.1);
  }
  request.mutable_subject()->mutable_shapes()->mutable_x_world_body()->set_data(
      PoseBytes(kBatchRows, 0));
  request.mutable_options()->set_max_results(4);
  return UnaryPlan("cwm.v1.QueryService/GetDistances", request);
}

void AddBatchClients(const MeasuredServer& server, Tally& tally, Clients& clients) {
  for (int i = 0; i < kBatchConnections; ++i) {
    const auto channel = server.NewChannel();
    for (int call = 0; call < kBatchesInFlight; ++call) {
      clients.Add([channel, plan = BatchPlan(), &tally, &clients] {
        CallWithRetry(channel, plan, clients.over(), tally);
      });
    }
  }
}

void AddScanClients(const MeasuredServer& server, Tally& tally, Clients& clients) {
  static const std::vector<std::vector<float>> clouds = ScanPoints();
  for (int i = 0; i < kScanConnections; ++i) {
    const auto& cloud = clouds[static_cast<std::size_t>(i) % clouds.size()];
    clients.Add([channel = server.NewChannel(),
                 plan = CloudUploadPlan(absl::StrCat("scan_", i), cloud), &tally,
                 &clients] { CallWithRetry(channel, plan, clients.over(), tally); });
  }
}

void AddHostileClients(MeasuredServer& server, std::atomic<int>& sent, Clients& clients) {
  auto armed = std::make_shared<std::vector<Armed>>();
  for (const HostileRequest& request : HostileRequests()) {
    if (std::count(HostileNames().begin(), HostileNames().end(), request.name) == 0) continue;
    auto target = std::make_unique<Target>(Target{.server = server});
    if (request.prepare && !request.prepare(*target, kHostileClients)) continue;
    armed->push_back({request, std::move(target)});
  }
  if (armed->empty()) return;
  for (int client = 0; client < kHostileClients; ++client) {
    // Each client begins at another place of the list.
    auto turn = std::make_shared<std::size_t>(static_cast<std::size_t>(client) * armed->size() /
                                              kHostileClients);
    clients.Add([armed, turn, client, &sent, &server] {
      constexpr auto kHeldFor = std::chrono::milliseconds(500);
      const Armed& attack = (*armed)[(*turn)++ % armed->size()];
      if (!server.running()) return std::this_thread::sleep_for(kHeldFor);
      Sent copy;
      attack.request.send(*attack.target, client, copy);
      ++sent;
      const auto start = SteadyClock::now();
      for (const auto& call : copy.calls) {
        if (SteadyClock::now() - start < kHeldFor) call->WaitUntilDone(kHeldFor);
      }
    });
  }
}

void AddSmallClient(const MeasuredServer& server, Tally& tally, Clients& clients) {
  v1::CheckCollisionsRequest request;
  request.set_world("small");
  request.mutable_subject()->mutable_shapes()->add_shapes()->mutable_sphere()->set_radius_m(0.05);
  request.mutable_subject()->mutable_shapes()->mutable_x_world_body()->set_data(PoseBytes(1, 0.1));
  clients.Add([channel = server.NewChannel(),
               plan = UnaryPlan("cwm.v1.QueryService/CheckCollisions", request), &tally] {
    const auto sent = SteadyClock::now();
    HeldCall call(channel, plan);
    call.WaitUntilDone(std::chrono::seconds(10));
    {
      const std::lock_guard lock(tally.mutex);
      tally.latencies_s.push_back(SecondsSince(sent));
      if (call.Outcome() != "OK") {
        ++tally.failed;
        if (tally.failure.empty())
          tally.failure = call.Outcome() + ": " + call.status().error_message();
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  });
}

bool PrepareOverload(MeasuredServer& server) { return PutBoxes(server, "small", 200); }

}  // namespace cwm::benchmarks
