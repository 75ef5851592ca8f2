// Three sensors beside queries and writes.
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <deque>
#include <map>
#include <string>
#include <thread>
#include <utility>

#include "tests/benchmarks/live/bench_robot.h"
#include "tests/benchmarks/live/live_benchmarks.h"
#include "tests/benchmarks/live/live_scenes.h"
#include "tests/benchmarks/live/live_world.h"
#include "tests/benchmarks/live/revision_probe.h"
#include "tests/benchmarks/running_server.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

constexpr int kSensors = 3;
constexpr double kSettle_s = 2, kAlone_s = 6, kMeasured_s = 8;
constexpr std::size_t kBatch = 10'000;
constexpr double kAsked_per_s = 6e6;
constexpr std::size_t kInFlight = 3;

v1::StreamQueriesRequest StatesOf(const BenchRobot& robot) {
  v1::StreamQueriesRequest request;
  v1::CheckCollisionsRequest& query = *request.mutable_check_collisions();
  query.set_world(kLiveWorld);
  query.mutable_options()->set_verdicts_only(true);
  v1::RobotSubject& subject = *query.mutable_subject()->mutable_robot();
  subject.set_robot(robot.name);
  subject.set_robot_geometry(robot.spheres.empty() ? v1::ROBOT_GEOMETRY_SPHERES_CONTAINING
                                                   : v1::ROBOT_GEOMETRY_SPHERES_AS_GIVEN);
  std::vector<double> rows;
  for (std::size_t i = 0; i < kBatch; ++i) {
    std::vector<double> row = robot.ready;
    row[0] += 1e-4 * static_cast<double>(i);
    rows.insert(rows.end(), row.begin(), row.end());
  }
  std::string* data = subject.mutable_rows()->mutable_data();
  data->resize(rows.size() * sizeof(double));
  std::memcpy(data->data(), rows.data(), data->size());
  return request;
}

// Asks for kAsked_per_s states a second, in batches, with some batches in flight; if the server
// answers fewer, the next batch waits for an answer.
class QueryLoad {
 public:
  QueryLoad(const std::string& address, const BenchRobot& robot)
      : connection_({.address = address, .deadline = std::nullopt}),
        request_(StatesOf(robot)),
        stream_(connection_.queries().StreamQueries(&context_)),
        thread_([this] { Run(); }) {}
  ~QueryLoad() { Stop(); }
  QueryLoad(const QueryLoad&) = delete;
  QueryLoad& operator=(const QueryLoad&) = delete;

  // Milliseconds of each batch, from sending it to its answer.
  std::vector<double> Stop() {
    stops_ = true;
    if (thread_.joinable()) thread_.join();
    return times_ms_;
  }
  bool has_failed() const { return has_failed_; }

 private:
  void Run() {
    std::deque<SteadyClock::time_point> sent;
    const auto start = SteadyClock::now();
    for (std::size_t i = 0; !stops_ && !has_failed_; ++i) {
      const auto due =
          std::chrono::duration<double>(static_cast<double>(i * kBatch) / kAsked_per_s);
      std::this_thread::sleep_until(start + std::chrono::duration_cast<SteadyClock::duration>(due));
      sent.push_back(SteadyClock::now());
      has_failed_ = !stream_->Write(request_);
      if (sent.size() == kInFlight) Receive(sent);
    }
    while (!sent.empty() && !has_failed_) Receive(sent);
    stream_->WritesDone();
    static_cast<void>(stream_->Finish());  // a failed batch was told by the read
  }

  void Receive(std::deque<SteadyClock::time_point>& sent) {
    v1::StreamQueriesResponse response;
    has_failed_ = has_failed_ || !stream_->Read(&response) || response.has_error();
    times_ms_.push_back(
        std::chrono::duration<double, std::milli>(SteadyClock::now() - sent.front()).count());
    sent.pop_front();
  }

  const client::Connection connection_;
  const v1::StreamQueriesRequest request_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamQueriesRequest, v1::StreamQueriesResponse>>
      stream_;
  std::atomic<bool> stops_ = false, has_failed_ = false;
  std::vector<double> times_ms_;
  std::thread thread_;
};

// Milliseconds of puts of one box, a hundred a second, until `stops`.
std::vector<double> Put(const std::string& address, const std::atomic<bool>& stops) {
  const client::Connection connection({.address = address, .deadline = std::chrono::seconds(10)});
  v1::ApplyChangesRequest request;
  request.set_world(kLiveWorld);
  v1::Object& object = *request.add_changes()->mutable_put()->mutable_object();
  object.set_name("written");
  SetShape(Box{.size_m = Vector3::Constant(0.03)}, object.add_shapes());
  std::vector<double> times_ms;
  for (int i = 0; !stops; ++i) {
    SetPose(MakeTranslation(1.5 + 1e-4 * (i % 100), 1, 2), object.mutable_x_world_object());
    const auto start = SteadyClock::now();
    const bool ok =
        connection.Call(&v1::WorldService::Stub::ApplyChanges, connection.worlds(), request).ok();
    times_ms.push_back(ok ? 1e3 * SecondsSince(start) : 1e4);
    std::this_thread::sleep_until(start + std::chrono::milliseconds(10));
  }
  return times_ms;
}

// What became of a sensor's frames from `first` on, in words.
std::string FatesOf(const std::vector<FrameAnswer>& answers, std::size_t first) {
  int processed = 0, dropped = 0, refused = 0, moved = 0, others = 0, movers = 0;
  std::map<std::string, int> reasons;
  for (std::size_t i = first; i < answers.size(); ++i) {
    const v1::StreamCloudsResponse& response = answers[i].response;
    processed += answers[i].is_processed();
    dropped += response.fate() == v1::FRAME_FATE_DROPPED;
    refused += response.fate() == v1::FRAME_FATE_REFUSED;
    moved += response.changes().moved_size() > 0;
    if (!response.reason().empty()) ++reasons[response.reason()];
    movers += response.changes().movers_size() > 0;
    others += response.changes().added_size() + response.changes().removed_size() +
              response.changes().replaced_size();
  }
  char text[200];
  std::snprintf(text, sizeof(text),
                "%d frames processed, %d dropped, %d refused; %d moved something, %d have movers; "
                "%d objects added, removed or replaced",
                processed, dropped, refused, moved, movers, others);
  std::string words = text;
  for (const auto& [reason, count] : reasons) words += "; " + std::to_string(count) + " " + reason;
  return words;
}

// What queries meet: objects with surfaces of triangles cost them more than shapes.
std::string ContentOf(LiveWorld& world) {
  const std::int64_t revision = world.Revision();
  if (!world.published().WaitFor(revision)) return "the world is not known";
  std::size_t objects = 0;
  std::string meshes;
  for (const auto& [name, object] : world.published().At(revision)) {
    ++objects;
    if (object->surfaces_size() == 0) continue;
    meshes += (meshes.empty() ? "" : ", ") + name + " (" + v1::ObjectKind_Name(object->kind()) +
              ", " + std::to_string(object->shapes_size()) + " shapes)";
  }
  return std::to_string(objects) +
         " objects; with surfaces of triangles: " + (meshes.empty() ? "none" : meshes);
}

using FramesBySensor = std::vector<std::vector<TrueFrame>>;

bool PlayAll(const std::vector<LiveSensor*>& sensors, FramesBySensor& frames) {
  std::atomic<bool> ok = true;
  std::vector<std::thread> players;
  for (std::size_t i = 0; i < sensors.size(); ++i) MoveToPresent(frames[i]);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    players.emplace_back([&, i] {
      if (!Play(*sensors[i], frames[i])) ok = false;
    });
  }
  for (std::thread& player : players) player.join();
  return ok;
}

}  // namespace

void MeasureLiveLoad(Report& report) {
  const auto robot = ReadBenchRobot();
  if (!robot.ok()) return report.Fail("no robot: " + robot.status().ToString());
  // Two runs over the same motion: beside queries, and beside writes.
  perception::SequenceScript script =
      PushedThing(kSettle_s, {.duration_s = kSettle_s + 2 * kMeasured_s, .sensor_count = kSensors});
  script.robots.push_back(SimulateRobot(*robot, {.times_s = {0}, .rows = {robot->ready}}));
  const perception::SequenceRenderer renderer(script);
  FramesBySensor settle(kSensors), queried(kSensors), written(kSensors);
  for (std::size_t i = 0; i < kSensors; ++i) {
    settle[i] = RenderFrames(renderer, i, 0, static_cast<int>(kSettle_s * 30));
    queried[i] = RenderFrames(renderer, i, static_cast<int>(kSettle_s * 30),
                              static_cast<int>(kMeasured_s * 30));
    written[i] = RenderFrames(renderer, i, static_cast<int>((kSettle_s + kMeasured_s) * 30),
                              static_cast<int>(kMeasured_s * 30));
  }
  LiveWorld world;
  if (!world.up()) return report.Fail("the server does not come up");
  const auto loaded = world.AddRobot(*robot, robot->ready);
  if (!loaded.ok()) return report.Fail("the robot cannot be loaded: " + loaded.ToString());
  const RestingStates states(world.address(), script.robots.front(), robot->ready);
  std::vector<LiveSensor*> sensors;
  for (std::size_t i = 0; i < kSensors; ++i) {
    sensors.push_back(&world.AddSensor(renderer.script().sensors[i].name, settle[i].front().frame));
    if (const std::string error = Settle(world, *sensors[i], settle[i]); !error.empty()) {
      return report.Fail(error);
    }
  }
  report.Detail("  the settled world has " + ContentOf(world));
  // The same world without frames.
  std::vector<double> alone_ms;
  {
    QueryLoad load(world.address(), *robot);
    std::this_thread::sleep_for(std::chrono::duration<double>(kAlone_s));
    alone_ms = load.Stop();
    if (load.has_failed()) return report.Fail("a query of the load failed");
  }
  std::vector<std::size_t> first;
  for (const LiveSensor* sensor : sensors) first.push_back(sensor->sent_count());
  std::vector<double> beside_ms, change_ms;
  {
    const RevisionProbe probe(world.address(), kLiveWorld);
    QueryLoad load(world.address(), *robot);
    if (!PlayAll(sensors, queried)) return report.Fail("a stream ended beside queries");
    beside_ms = load.Stop();
    if (load.has_failed()) return report.Fail("a query of the load failed beside sensors");
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      const auto answers = sensors[i]->answers();
      const auto times_ms = ChangeTimes_ms(answers, first[i], probe);
      change_ms.insert(change_ms.end(), times_ms.begin(), times_ms.end());
      report.Detail("  " + renderer.script().sensors[i].name +
                    " beside queries: " + FatesOf(answers, first[i]));
    }
  }
  char text[240];
  std::snprintf(
      text, sizeof(text),
      "  batches of 10 000 states: %.2f M states/s beside three sensors, alone %.2f M states/s",
      1e-6 * kBatch * static_cast<double>(beside_ms.size()) / kMeasured_s,
      1e-6 * kBatch * static_cast<double>(alone_ms.size()) / kAlone_s);
  report.Detail(text);
  if (change_ms.empty()) return report.Fail("no frame moved the pushed thing");
  std::atomic<bool> stops = false;
  std::vector<double> put_ms;
  std::thread writer([&] { put_ms = Put(world.address(), stops); });
  const bool is_played = PlayAll(sensors, written);
  stops = true;
  writer.join();
  if (!is_played) return report.Fail("a stream ended beside writes");
  report.Add(
      BesideYardstick({.key = "live_three_sensors_p95_ms",
                       .value = Quantile(change_ms, 0.95),
                       .unit = "ms",
                       .how = "as live_change_p95_ms, three sensors at 30 Hz beside a client "
                              "that asks for 6 M states of spheres a second"},
                      50, std::nullopt, report));
  std::snprintf(text, sizeof(text),
                "p99 of a batch of 10 000 states beside three sensors, %.1f ms, to that without, "
                "%.1f ms",
                Quantile(beside_ms, 0.99), Quantile(alone_ms, 0.99));
  report.Add(WithLimit({.key = "live_query_p99_ratio",
                        .value = Quantile(beside_ms, 0.99) / Quantile(alone_ms, 0.99),
                        .unit = "x",
                        .how = text},
                       2));
  report.Add(WithLimit({.key = "live_put_p99_ms",
                        .value = Quantile(put_ms, 0.99),
                        .unit = "ms",
                        .how = "p99 of " + std::to_string(put_ms.size()) +
                               " puts of a box beside three sensors, 100 a second"},
                       5));
}

}  // namespace cwm::benchmarks
