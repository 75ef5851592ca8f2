#include "tests/benchmarks/store/write_load.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

namespace cwm::benchmarks {
namespace {

constexpr auto kPatience = std::chrono::seconds(30);
constexpr double kWarmUp_s = 1;

std::string WorldName(int index) { return "w" + std::to_string(index); }

bool WaitUntilServing(const MeasuredServer& server) {
  const auto start = SteadyClock::now();
  while (server.running() && SteadyClock::now() - start < kPatience) {
    const client::Connection& connection = server.connection();
    if (connection
            .Call(&v1::WorldService::Stub::ListWorlds, connection.worlds(), v1::ListWorldsRequest())
            .ok()) {
      return true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

bool Write(const MeasuredServer& server, const v1::ApplyChangesRequest& request) {
  const client::Connection& connection = server.connection();
  return connection.Call(&v1::WorldService::Stub::ApplyChanges, connection.worlds(), request).ok();
}

// Has a call under way all the time, from one callback of gRPC to the next, so that a writer takes
// no thread.
class Writer {
 public:
  Writer(std::shared_ptr<grpc::Channel> channel, const std::string& world, int index)
      : stub_(v1::WorldService::NewStub(std::move(channel))),
        request_(MoveOfBox(world, index, 0)) {}

  void Start() { Next(); }
  // Of the calls that begin from now on.
  void BeginToMeasure() { measures_ = true; }
  // Waits until the last call has ended. False if a call failed.
  bool Stop() {
    stops_ = true;
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [this] { return has_ended_; });
    return !has_failed_;
  }
  const std::vector<double>& wall_ms() const { return wall_ms_; }

 private:
  void Next() {
    context_ = std::make_unique<grpc::ClientContext>();
    v1::Pose& pose = *request_.mutable_changes(0)->mutable_move()->mutable_x_world_object();
    pose.set_tx_m(1e-6 * static_cast<double>(++count_));
    is_measured_ = measures_;
    sent_ = SteadyClock::now();
    stub_->async()->ApplyChanges(context_.get(), &request_, &response_,
                                 [this](const grpc::Status& status) { OnDone(status); });
  }

  void OnDone(const grpc::Status& status) {
    if (is_measured_) wall_ms_.push_back(SecondsSince(sent_) * 1e3);
    if (status.ok() && !stops_) return Next();
    const std::lock_guard lock(mutex_);
    has_failed_ = !status.ok();
    has_ended_ = true;
    ended_.notify_all();
  }

  const std::unique_ptr<v1::WorldService::Stub> stub_;
  v1::ApplyChangesRequest request_;
  v1::ApplyChangesResponse response_;
  std::unique_ptr<grpc::ClientContext> context_;
  SteadyClock::time_point sent_;
  bool is_measured_ = false;
  std::int64_t count_ = 0;
  std::vector<double> wall_ms_;
  std::atomic<bool> measures_ = false, stops_ = false;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool has_failed_ = false, has_ended_ = false;
};

// The sum over all worlds; -1 if one does not answer.
std::int64_t Revisions(const MeasuredServer& server, int worlds) {
  const client::Connection& connection = server.connection();
  std::int64_t sum = 0;
  for (int i = 0; i < worlds; ++i) {
    v1::GetWorldRequest request;
    request.set_world(WorldName(i));
    const auto world =
        connection.Call(&v1::WorldService::Stub::GetWorld, connection.worlds(), request);
    if (!world.ok()) return -1;
    sum += world->revision();
  }
  return sum;
}

void SleepSeconds(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

}  // namespace

std::unique_ptr<MeasuredServer> StartServer(const std::string& store_directory) {
  MeasuredServerOptions options;
  options.arguments = {"--store", store_directory.empty() ? "memory" : "sqlite:" + store_directory};
  auto server = std::make_unique<MeasuredServer>(options);
  if (!server->up() || !WaitUntilServing(*server)) return nullptr;
  return server;
}

v1::ApplyChangesRequest MoveOfBox(const std::string& world, int index, double x_m) {
  v1::ApplyChangesRequest request;
  request.set_world(world);
  v1::MoveObject& move = *request.add_changes()->mutable_move();
  move.set_name("box_" + std::to_string(index));
  move.mutable_x_world_object()->set_tx_m(x_m);
  move.mutable_x_world_object()->set_qw(1);
  return request;
}

bool PutMovableBoxes(const MeasuredServer& server, const std::string& world, int count) {
  constexpr double kEdge_m = 0.05, kDistance_m = 0.2;
  v1::ApplyChangesRequest request;
  request.set_world(world);
  for (int i = 0; i < count; ++i) {
    v1::Object& object = *request.add_changes()->mutable_put()->mutable_object();
    object.set_name("box_" + std::to_string(i));
    object.mutable_x_world_object()->set_ty_m(kDistance_m * i);
    object.mutable_x_world_object()->set_qw(1);
    v1::Box& box = *object.add_shapes()->mutable_box();
    box.set_size_x_m(kEdge_m);
    box.set_size_y_m(kEdge_m);
    box.set_size_z_m(kEdge_m);
  }
  return Write(server, request);
}

WriteRates MeasureWriters(const MeasuredServer& server, int writers, int worlds, double seconds) {
  for (int i = 0; i < worlds; ++i) {
    if (!PutMovableBoxes(server, WorldName(i), writers)) return {};
  }
  std::vector<std::unique_ptr<Writer>> all;
  for (int i = 0; i < writers; ++i) {
    all.push_back(std::make_unique<Writer>(server.NewChannel(), WorldName(i % worlds), i));
  }
  for (const auto& writer : all) writer->Start();
  SleepSeconds(kWarmUp_s);
  for (const auto& writer : all) writer->BeginToMeasure();
  const auto start = SteadyClock::now();
  const std::int64_t before = Revisions(server, worlds);
  SleepSeconds(seconds);
  WriteRates rates;
  rates.seconds = SecondsSince(start);
  const std::int64_t after = Revisions(server, worlds);
  rates.ok = before >= 0 && after >= 0;
  rates.revisions = after - before;
  for (const auto& writer : all) {
    rates.ok = writer->Stop() && rates.ok;
    rates.wall_ms.insert(rates.wall_ms.end(), writer->wall_ms().begin(), writer->wall_ms().end());
  }
  return rates;
}

}  // namespace cwm::benchmarks
