#include "tests/fault/workload.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace cwm::fault {
namespace {

using Kind = Operation::Kind;
using Outcome = Operation::Outcome;

// Few names, so that writers meet.
constexpr int kNames = 12;
// derived: 36 bytes each, so more than 64 KiB: the store keeps it as a file.
constexpr int kLargeMeshVertices = 2'000;
constexpr int kSmallMeshVertices = 24;
constexpr int kInlineMeshVertices = 1'650;  // 60 KB, less than that
constexpr char kShortLived[] = "short_lived";
constexpr int kWritesInWorld = 6;
// chosen: between retries after a refusal that asks for one.
constexpr auto kRefusedPause = std::chrono::milliseconds(20);

}  // namespace

struct Workload::Client {
  int number = 0;
  std::mt19937 random = {};
  std::int64_t written = 0;  // numbers its requests
  std::optional<Operation> pending = {};
  bool has_robot = false;  // of the client that sets the robot's state
  std::int64_t joint = 0;
  std::string world_uid = {};  // of the client that makes worlds; empty: it is to be made
  int writes_in_world = 0;

  int Draw(int count) { return static_cast<int>(random() % static_cast<std::uint32_t>(count)); }
};

struct Workload::Watcher {
  int number = 0;
  bool is_lossless = true;
  std::optional<std::int64_t> reached = {};
  std::mutex mutex = {};
  grpc::ClientContext* context = nullptr;  // of the stream that is open
  std::atomic<std::int64_t> seen = 0;
};

Workload::Workload(const WorkloadOptions& options) : options_(options) {
  int number = kInspector;
  const int writers = options_.writers + 3;  // and one for worlds, for states, for reading
  for (int i = 0; i < writers; ++i) {
    clients_.push_back(std::make_unique<Client>());
    clients_.back()->number = ++number;
    clients_.back()->random.seed(options_.seed * 1'000 + static_cast<std::uint32_t>(number));
  }
  for (const bool is_lossless : {true, false}) {
    watchers_.push_back(std::make_unique<Watcher>());
    watchers_.back()->number = ++number;
    watchers_.back()->is_lossless = is_lossless;
  }
}

Workload::~Workload() { Stop(); }

bool Workload::Prepare(const std::string& address) {
  const client::Connection connection({.address = address, .deadline = options_.deadline});
  Operation operation{.client = kInspector,
                      .world = kMain,
                      .request_id = "prepare-" + std::to_string(options_.seed),
                      .changes = {{.name = "table", .geometry = "box:1024:1024:32"}}};
  Send(connection, operation);
  recorder_.Add(operation);
  if (operation.outcome != Outcome::kOk) return false;
  main_uid_ = operation.world_uid;
  Note(operation);
  return true;
}

void Workload::Start(const std::string& address) {
  stopping_ = false;
  const auto run = [&](void (Workload::*body)(Client&, const std::string&), Client& client) {
    threads_.emplace_back([this, body, &client, address] { (this->*body)(client, address); });
  };
  const auto writers = static_cast<std::size_t>(options_.writers);
  for (std::size_t i = 0; i < writers; ++i) run(&Workload::RunWriter, *clients_[i]);
  if (options_.has_worlds) run(&Workload::RunWorlds, *clients_[writers]);
  if (options_.has_states) run(&Workload::RunStates, *clients_[writers + 1]);
  run(&Workload::RunReader, *clients_[writers + 2]);
  for (const auto& watcher : watchers_) {
    watch_threads_.emplace_back(
        [this, &watcher = *watcher, address] { RunWatcher(watcher, address); });
  }
}

void Workload::Stop() {
  stopping_ = true;
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  for (const auto& watcher : watchers_) {
    const std::lock_guard lock(watcher->mutex);
    if (watcher->context != nullptr) watcher->context->TryCancel();
  }
  for (std::thread& thread : watch_threads_) thread.join();
  watch_threads_.clear();
}

bool Workload::Finish(std::chrono::milliseconds patience) {
  finishing_ = true;
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  finishing_ = false;
  const auto end = std::chrono::steady_clock::now() + patience;
  const auto are_done = [&] {
    return std::all_of(watchers_.begin(), watchers_.end(),
                       [&](const auto& watcher) { return watcher->seen >= newest_; });
  };
  while (!are_done() && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  const bool done = are_done();
  Stop();
  return done && std::none_of(clients_.begin(), clients_.end(),
                              [](const auto& client) { return client->pending.has_value(); });
}

bool Workload::PutMeshes(const std::string& address, int count) {
  const client::Connection connection({.address = address, .deadline = options_.deadline});
  Client& client = *clients_.front();
  for (int i = 0; i < count; ++i) {
    Operation operation = NewOperation(client, kMain, main_uid_);
    const NumberedMesh mesh = MakeMesh(client.written, kInlineMeshVertices);
    if (!UploadMesh(connection, mesh)) return false;
    operation.changes = {{.name = "object_" + std::to_string(i % kNames),
                          .place = {0, client.written * 16 + client.number, 0},
                          .geometry = mesh.geometry}};
    Send(connection, operation);
    recorder_.Add(operation);
    Note(operation);
    if (operation.outcome != Outcome::kOk) return false;
  }
  return true;
}

void Workload::SetClockAhead() {
  recorder_.Add(Operation{.kind = Kind::kClockAhead, .invoke_ns = NowNs()});
}

void Workload::Note(const Operation& operation) {
  if (operation.outcome != Outcome::kOk || operation.world_uid != main_uid_) return;
  std::int64_t known = newest_;
  while (known < operation.revision && !newest_.compare_exchange_weak(known, operation.revision)) {
  }
}

Operation Workload::NewOperation(Client& client, const std::string& world,
                                 const std::string& uid) const {
  return {.client = client.number,
          .world = world,
          .world_uid = uid,
          .request_id = std::to_string(options_.seed) + "-" + std::to_string(client.number) + "-" +
                        std::to_string(++client.written)};
}

template <class Make>
Workload::Answer Workload::Step(Client& client, const client::Connection& connection,
                                const Make& make) {
  if (!client.pending) client.pending = make();
  Send(connection, *client.pending);
  recorder_.Add(*client.pending);
  const Operation answered = *client.pending;
  Note(answered);
  if (answered.outcome == Outcome::kUnknown) return {.is_lost = true};
  if (answered.outcome == Outcome::kOk) ++written_;
  if (answered.reason == "DISK_FULL") ++full_;
  // The server is full, draining or replaying: the same request is sent again.
  if (answered.reason == "DISK_FULL" || answered.reason == "STORE_REPLAYING" ||
      answered.reason == "SERVER_DRAINING") {
    std::this_thread::sleep_for(kRefusedPause);
    return {};
  }
  client.pending.reset();
  std::this_thread::sleep_for(options_.pause);
  return {.operation = answered};
}

Change Workload::MakeChange(Client& client, const client::Connection& connection) {
  const std::string name = "object_" + std::to_string(client.Draw(kNames));
  // The second number is the client's and the request's own, so that each write can be told from
  // all others by what it leaves.
  const Place place = {client.Draw(2'048), client.written * 16 + client.number, client.Draw(1'024)};
  const int kind = client.Draw(100);
  if (kind < 35) return {.kind = Change::Kind::kMove, .name = name, .place = place};
  if (kind < 45) return {.kind = Change::Kind::kRemove, .name = name};
  if (kind < 50) return {.kind = Change::Kind::kAttach, .name = name, .other = kRobot};
  if (kind < 53) return {.kind = Change::Kind::kDetach, .name = name};
  const std::string other = "object_" + std::to_string(client.Draw(kNames)) + "x";
  if (kind < 57) {
    return {.kind = Change::Kind::kAllow, .name = name, .other = other, .value = client.Draw(2)};
  }
  if (kind < 61) {
    return {.kind = Change::Kind::kMargin,
            .name = name,
            .other = other,
            .value = client.Draw(3) == 0 ? -1 : place[1]};
  }
  std::string geometry = "box:" + std::to_string(1 + client.Draw(512)) + ":" +
                         std::to_string(1 + client.Draw(512)) + ":" +
                         std::to_string(1 + client.Draw(512));
  if (kind >= 92) {
    const NumberedMesh mesh =
        MakeMesh(place[1], kind >= 96 ? kLargeMeshVertices : kSmallMeshVertices);
    if (UploadMesh(connection, mesh)) geometry = mesh.geometry;
  }
  return {.kind = Change::Kind::kPut, .name = name, .place = place, .geometry = geometry};
}

Operation Workload::MakeWrite(Client& client, const client::Connection& connection) {
  Operation operation = NewOperation(client, kMain, main_uid_);
  const int changes = client.Draw(4) == 0 ? 2 + client.Draw(2) : 1;
  for (int i = 0; i < changes; ++i) operation.changes.push_back(MakeChange(client, connection));
  if (client.Draw(8) == 0) operation.expected_revision = newest_;
  return operation;
}

bool Workload::GoesOn(const Client& client) const {
  return !stopping_ && !(finishing_ && !client.pending);
}

void Workload::RunWriter(Client& client, const std::string& address) {
  const client::Connection connection({.address = address, .deadline = options_.deadline});
  while (GoesOn(client)) {
    if (Step(client, connection, [&] { return MakeWrite(client, connection); }).is_lost) return;
  }
}

// Loads the robot, sets its state many times, deletes it now and then.
Operation Workload::MakeRobotWrite(Client& client) const {
  Operation operation = NewOperation(client, kMain, main_uid_);
  Change change{.name = kRobot};
  if (!client.has_robot) {
    change.kind = Change::Kind::kLoadRobot;
  } else if (client.Draw(200) == 0) {
    change.kind = Change::Kind::kDeleteRobot;
  } else {
    change.kind = Change::Kind::kRobotState;
    change.value = ++client.joint % 100'000;
  }
  operation.changes = {change};
  return operation;
}

void Workload::RunStates(Client& client, const std::string& address) {
  const client::Connection connection({.address = address, .deadline = options_.deadline});
  while (GoesOn(client)) {
    const Answer answer = Step(client, connection, [&] { return MakeRobotWrite(client); });
    if (answer.is_lost) return;
    if (answer.operation && answer.operation->outcome == Outcome::kOk) {
      client.has_robot = answer.operation->changes[0].kind != Change::Kind::kDeleteRobot;
    }
  }
}

// Writes to its world, which the first write makes, and deletes it at last.
Operation Workload::MakeWorldWrite(Client& client) const {
  Operation operation = NewOperation(client, kShortLived, client.world_uid);
  if (client.writes_in_world < kWritesInWorld) {
    operation.changes = {{.name = "object_" + std::to_string(client.writes_in_world),
                          .place = {0, client.written * 16 + client.number, 0},
                          .geometry = "box:64:64:64"}};
  } else {
    operation.kind = Kind::kDelete;
  }
  return operation;
}

void Workload::RunWorlds(Client& client, const std::string& address) {
  const client::Connection connection({.address = address, .deadline = options_.deadline});
  while (GoesOn(client)) {
    const Answer answer = Step(client, connection, [&] { return MakeWorldWrite(client); });
    if (answer.is_lost) return;
    if (!answer.operation) continue;
    const std::lock_guard lock(live_mutex_);
    if (answer.operation->kind == Kind::kWrite && answer.operation->outcome == Outcome::kOk) {
      ++client.writes_in_world;
      client.world_uid = answer.operation->world_uid;
      live_[kShortLived] = client.world_uid;
    } else {
      client.writes_in_world = 0;
      client.world_uid.clear();
      live_.erase(kShortLived);
    }
  }
}

void Workload::RunReader(Client& client, const std::string& address) {
  const client::Connection connection({.address = address, .deadline = options_.deadline});
  while (!stopping_ && !finishing_) {
    Operation operation{.client = client.number, .world = kMain, .world_uid = main_uid_};
    const std::int64_t newest = newest_;
    switch (client.Draw(3)) {
      case 0:
        break;
      case 1:
        operation.at = Operation::At::kAtLeast;
        operation.asked_revision = newest;
        break;
      default:
        operation.at = Operation::At::kExact;
        operation.asked_revision = std::max<std::int64_t>(1, newest - client.Draw(60));
        break;
    }
    Read(connection, operation);
    recorder_.Add(operation);
    if (operation.outcome == Outcome::kUnknown) return;
    if (operation.outcome == Outcome::kOk) ++reads_;
    std::this_thread::sleep_for(10 * options_.pause);
  }
}

void Workload::RunWatcher(Watcher& watcher, const std::string& address) {
  const client::Connection connection({.address = address, .deadline = std::nullopt});
  // The second time if the first one ended with an error that asks for the whole state.
  for (int i = 0; i < 2 && !stopping_; ++i) {
    Watch watch{.client = watcher.number,
                .world = kMain,
                .world_uid = main_uid_,
                .from_revision = watcher.reached,
                .is_lossless = watcher.is_lossless};
    grpc::ClientContext context;
    {
      const std::lock_guard lock(watcher.mutex);
      watcher.context = &context;
    }
    Follow(connection, context, watch, [&](const Watch& so_far) {
      watcher.seen = ReachedBy(so_far);
      return true;
    });
    {
      const std::lock_guard lock(watcher.mutex);
      watcher.context = nullptr;
    }
    if (!watch.messages.empty()) watcher.reached = ReachedBy(watch);
    const bool again =
        watch.end_reason == "REVISION_COMPACTED" || watch.end_reason == "REVISION_IN_FUTURE";
    if (again) watcher.reached.reset();
    recorder_.Add(std::move(watch));
    if (!again) return;
  }
}

std::string Workload::InspectMain(const client::Connection& connection, bool whole,
                                  bool after_restart) {
  Operation read{
      .client = kInspector, .world = kMain, .world_uid = main_uid_, .after_restart = after_restart};
  Read(connection, read);
  std::string error;
  const bool ok = read.outcome == Outcome::kOk && (!whole || ReadFiles(connection, read, error));
  recorder_.Add(read);
  if (!ok) return "reading main failed: " + read.reason + error;
  Watch watch{.client = kInspector,
              .world = kMain,
              .world_uid = main_uid_,
              .from_revision = whole ? 0 : std::min(inspected_, read.revision)};
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
  Follow(connection, context, watch,
         [&](const Watch& so_far) { return ReachedBy(so_far) < read.revision; });
  const std::int64_t reached = ReachedBy(watch);
  const std::string end_reason = watch.end_reason;
  recorder_.Add(std::move(watch));
  inspected_ = read.revision;
  if (after_restart) newest_ = read.revision;  // a power cut may have taken some
  if (reached >= read.revision || end_reason == "REVISION_COMPACTED") return {};
  return "the watch of main did not reach revision " + std::to_string(read.revision) + " but " +
         std::to_string(reached) + " " + end_reason;
}

std::string Workload::Inspect(const std::string& address, bool whole, bool after_restart) {
  const client::Connection connection({.address = address, .deadline = options_.deadline});
  if (std::string wrong = InspectMain(connection, whole, after_restart); !wrong.empty()) {
    return wrong;
  }
  const std::lock_guard lock(live_mutex_);
  for (const auto& [name, uid] : live_) {
    Operation read{
        .client = kInspector, .world = name, .world_uid = uid, .after_restart = after_restart};
    Read(connection, read);
    recorder_.Add(read);
    if (read.outcome == Outcome::kUnknown) return "reading " + name + " failed: " + read.reason;
  }
  return {};
}

}  // namespace cwm::fault
