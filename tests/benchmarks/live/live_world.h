// A server whose world follows the sensors of a script, for one measurement.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "perception/simulation/deliveries.h"
#include "tests/benchmarks/live/bench_robot.h"
#include "tests/benchmarks/live/live_client.h"
#include "tests/benchmarks/live/published_world.h"
#include "tests/benchmarks/live/recorded_frames.h"
#include "tests/benchmarks/server/measured_server.h"

namespace cwm::benchmarks {

inline constexpr char kLiveWorld[] = "live";

// Adds a time to the stamps of all frames, and returns it: the first frame is of this moment.
double MoveToPresent(std::vector<TrueFrame>& frames);
void MoveStamps(double by_s, std::vector<TrueFrame>& frames);
// Adds one time to the stamps of the frames of all sensors of a script, so that none is of the
// future however fast they are sent.
void MoveToPast(std::vector<std::vector<TrueFrame>>& frames);

// Sends a robot's states at the pace of their deliveries, from a thread of its own.
class StatePlayer {
 public:
  // `begin_s` is the time of the script that is now; stamps are increased by `stamp_offset_s`.
  StatePlayer(const std::string& address, const perception::SimulatedRobot& robot,
              std::vector<perception::JointStateDelivery> states, double begin_s,
              double stamp_offset_s);
  ~StatePlayer();
  StatePlayer(const StatePlayer&) = delete;
  StatePlayer& operator=(const StatePlayer&) = delete;

 private:
  std::jthread thread_;
};

// Says a hundred times a second that the robot stands still, from a thread of its own.
class RestingStates {
 public:
  RestingStates(const std::string& address, const perception::SimulatedRobot& robot,
                std::vector<double> values);

 private:
  std::jthread thread_;
};

struct LiveWorldOptions {
  int cores = 0;  // that the server may use; 0: all
};

class LiveWorld {
 public:
  explicit LiveWorld(const LiveWorldOptions& options = {});

  bool up() const { return server_.up(); }
  const MeasuredServer& server() const { return server_; }
  std::string address() const { return "unix:" + server_.socket_path(); }

  // Opens the stream of a sensor; it stands still, or each frame has its pose.
  LiveSensor& AddSensor(const std::string& name, const RecordedFrame& first, bool is_fixed = true);
  // Loads the robot in its first state. Before the first sensor's frames.
  absl::Status AddRobot(const BenchRobot& robot, const std::vector<double>& state);
  // Puts boxes of users below the table, in the sensors' view but hidden by the table's top.
  absl::Status PutHiddenBoxes(int count);

  // The watch of the world, which exists after the first frame; begins at the first call.
  PublishedWorld& published();
  // The world's newest revision; -1 if it does not answer.
  std::int64_t Revision() const;

 private:
  MeasuredServer server_;
  std::vector<std::unique_ptr<LiveSensor>> sensors_;
  std::unique_ptr<PublishedWorld> published_;
};

// Sends the frames at the pace of their stamps; false if the stream ends. Waits for the answers of
// all, but never before it sends the next.
bool Play(LiveSensor& sensor, const std::vector<TrueFrame>& frames);

// Sends the frame, waits for its answer, and, if that says so, until what is being interpreted
// beside the frames is done: the world then does not depend on the machine's speed. Empty if the
// stream ends or the server is busy for a minute.
std::optional<FrameAnswer> SendAndSettle(const LiveWorld& world, LiveSensor& sensor,
                                         const RecordedFrame& frame);

// Plays still frames again and again until the world holds something, and for a whole round has
// made no revision and nothing of the view was being interpreted. An error in words if that takes
// longer than 40 s or the stream ends; empty otherwise.
std::string Settle(const LiveWorld& world, LiveSensor& sensor, std::vector<TrueFrame>& still);

}  // namespace cwm::benchmarks
