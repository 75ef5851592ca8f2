#include "tests/benchmarks/live/live_world.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <utility>

#include "clients/cpp/sensor_stream.h"
#include "tests/benchmarks/live/live_scenes.h"
#include "tests/benchmarks/running_server.h"

namespace cwm::benchmarks {
namespace {

constexpr auto kPatience = std::chrono::seconds(20);

double Now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

v1::RobotStateRows RowOf(const std::vector<double>& state, double stamp_s) {
  v1::RobotStateRows rows;
  SetStamp(stamp_s, rows.add_stamps());
  v1::JointRows& values = *rows.mutable_rows();
  values.set_scalar(v1::SCALAR_F64);
  values.set_width(static_cast<std::int32_t>(state.size()));
  values.mutable_data()->resize(state.size() * sizeof(double));
  std::memcpy(values.mutable_data()->data(), state.data(), values.data().size());
  return rows;
}

v1::RobotStatesHeader HeaderOf(const perception::SimulatedRobot& robot) {
  v1::RobotStatesHeader header;
  header.set_world(kLiveWorld);
  header.set_robot(robot.name);
  for (const std::string& variable : robot.variables) header.add_variables(variable);
  return header;
}

}  // namespace

double MoveToPresent(std::vector<TrueFrame>& frames) {
  if (frames.empty()) return 0;
  const double by_s = Now_s() - frames.front().frame.stamp_s;
  MoveStamps(by_s, frames);
  return by_s;
}

void MoveStamps(double by_s, std::vector<TrueFrame>& frames) {
  for (TrueFrame& frame : frames) frame.frame.stamp_s += by_s;
}

void MoveToPast(std::vector<std::vector<TrueFrame>>& frames) {
  double last_s = -INFINITY;
  for (const std::vector<TrueFrame>& sensor : frames) {
    if (!sensor.empty()) last_s = std::max(last_s, sensor.back().frame.stamp_s);
  }
  const double by_s = Now_s() - last_s;
  for (std::vector<TrueFrame>& sensor : frames) MoveStamps(by_s, sensor);
}

StatePlayer::StatePlayer(const std::string& address, const perception::SimulatedRobot& robot,
                         std::vector<perception::JointStateDelivery> states, double begin_s,
                         double stamp_offset_s) {
  thread_ = std::jthread([address, header = HeaderOf(robot), states = std::move(states), begin_s,
                          stamp_offset_s](const std::stop_token& stop) {
    const client::Connection connection({.address = address, .deadline = std::nullopt});
    client::RobotStateStream stream(connection, header);
    const Pace pace(begin_s);
    for (const perception::JointStateDelivery& state : states) {
      if (state.delivery_s < begin_s - 0.1) continue;
      pace.WaitFor(state.delivery_s);
      if (stop.stop_requested() ||
          !stream.Send(RowOf(state.values, state.stamp_s + stamp_offset_s)))
        return;
    }
  });
}

StatePlayer::~StatePlayer() = default;

RestingStates::RestingStates(const std::string& address, const perception::SimulatedRobot& robot,
                             std::vector<double> values)
    : thread_([address, header = HeaderOf(robot),
               values = std::move(values)](const std::stop_token& stop) {
        const client::Connection connection({.address = address, .deadline = std::nullopt});
        client::RobotStateStream stream(connection, header);
        while (!stop.stop_requested() && stream.Send(RowOf(values, Now_s()))) {
          std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
      }) {}

LiveWorld::LiveWorld(const LiveWorldOptions& options) : server_({.cores = options.cores}) {}

LiveSensor& LiveWorld::AddSensor(const std::string& name, const RecordedFrame& first,
                                 bool is_fixed) {
  sensors_.push_back(
      std::make_unique<LiveSensor>(address(), CalibrationOf(kLiveWorld, name, first, is_fixed)));
  return *sensors_.back();
}

absl::Status LiveWorld::AddRobot(const BenchRobot& robot, const std::vector<double>& state) {
  return LoadBenchRobot(server_.connection(), kLiveWorld, robot, state);
}

absl::Status LiveWorld::PutHiddenBoxes(int count) {
  constexpr int kPerRow = 20;
  constexpr double kEdge_m = 0.03, kStep_m = 0.05;
  v1::ApplyChangesRequest request;
  request.set_world(kLiveWorld);
  for (int i = 0; i < count; ++i) {
    v1::Object& object = *request.add_changes()->mutable_put()->mutable_object();
    object.set_name("stored_" + std::to_string(i));
    SetPose(MakeTranslation(0.5 + kStep_m * (i / kPerRow), kStep_m * (i % kPerRow - 0.5 * kPerRow),
                            kTableTop_m - 0.2),
            object.mutable_x_world_object());
    SetShape(Box{.size_m = Vector3::Constant(kEdge_m)}, object.add_shapes());
  }
  const client::Connection& connection = server_.connection();
  return connection.Call(&v1::WorldService::Stub::ApplyChanges, connection.worlds(), request)
      .status();
}

PublishedWorld& LiveWorld::published() {
  if (published_ == nullptr) published_ = std::make_unique<PublishedWorld>(address(), kLiveWorld);
  return *published_;
}

std::int64_t LiveWorld::Revision() const {
  v1::GetWorldRequest request;
  request.set_world(kLiveWorld);
  const client::Connection& connection = server_.connection();
  const auto world =
      connection.Call(&v1::WorldService::Stub::GetWorld, connection.worlds(), request);
  return world.ok() ? world->revision() : -1;
}

bool Play(LiveSensor& sensor, const std::vector<TrueFrame>& frames) {
  if (frames.empty()) return true;
  const std::size_t before = sensor.sent_count();
  const Pace pace(frames.front().frame.stamp_s);
  for (const TrueFrame& frame : frames) {
    pace.WaitFor(frame.frame.stamp_s);
    if (!sensor.Send(frame.frame)) return false;
  }
  return sensor.WaitForAnswers(before + frames.size(), kPatience);
}

std::optional<FrameAnswer> SendAndSettle(const LiveWorld& world, LiveSensor& sensor,
                                         const RecordedFrame& frame) {
  constexpr double kMaxCpu_s = 20;
  auto answer = sensor.SendAndWait(frame);
  if (answer && answer->response.interpreting() && !world.server().WaitUntilIdle(kMaxCpu_s)) {
    return std::nullopt;
  }
  return answer;
}

std::string Settle(const LiveWorld& world, LiveSensor& sensor, std::vector<TrueFrame>& still) {
  constexpr double kLimit_s = 40;
  const auto start = SteadyClock::now();
  while (SecondsSince(start) < kLimit_s) {
    const std::int64_t before = world.Revision();
    const std::size_t first = sensor.sent_count();
    MoveToPresent(still);
    if (!Play(sensor, still)) return "the stream ended: " + sensor.Finish();
    const std::vector<FrameAnswer> answers = sensor.answers();
    bool is_calm = before > 0 && world.Revision() == before;
    for (std::size_t i = first; i < answers.size(); ++i) {
      is_calm = is_calm && !answers[i].response.interpreting();
    }
    if (is_calm) return {};
  }
  return "the world of a static scene was still being interpreted or changed after 40 s";
}

}  // namespace cwm::benchmarks
