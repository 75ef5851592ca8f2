// A client with a running sensor: sends frames, and keeps the answer to each with its times.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "clients/cpp/connection.h"
#include "clients/cpp/sensor_stream.h"
#include "cwm/v1/perception.pb.h"
#include "tests/benchmarks/live/recorded_frames.h"

namespace cwm::benchmarks {

using SteadyClock = std::chrono::steady_clock;

// A frame's way through the server. `sent` is when its last byte was handed to the socket.
struct FrameAnswer {
  SteadyClock::time_point begun = {}, sent = {}, answered = {};
  v1::StreamCloudsResponse response = {};

  double Answer_ms() const {
    return std::chrono::duration<double, std::milli>(answered - sent).count();
  }
  bool is_processed() const { return response.fate() == v1::FRAME_FATE_PROCESSED; }
};

// The calibration of a sensor whose frames look like this one: with its pose if it stands still.
v1::SensorCalibration CalibrationOf(const std::string& world, const std::string& sensor,
                                    const RecordedFrame& frame, bool is_fixed);

// One thread sends; another of this class reads the answers. Has a connection of its own.
class LiveSensor {
 public:
  LiveSensor(const std::string& address, v1::SensorCalibration calibration);
  ~LiveSensor();
  LiveSensor(const LiveSensor&) = delete;
  LiveSensor& operator=(const LiveSensor&) = delete;

  // Returns the frame's number in the stream; empty if the stream is over.
  std::optional<std::size_t> Send(const RecordedFrame& frame);
  // Waits until that many frames are answered; false if the stream ends or `patience` passes first.
  bool WaitForAnswers(std::size_t count, std::chrono::milliseconds patience);
  // Sends the frame and waits for its answer.
  std::optional<FrameAnswer> SendAndWait(const RecordedFrame& frame);
  // The answers so far, by the frames' numbers; frames without an answer have no fate.
  std::vector<FrameAnswer> answers() const;
  std::size_t sent_count() const;
  // Ends the stream; the reason in words if it did not end well.
  std::string Finish();

 private:
  void Read();

  const bool is_fixed_;
  const client::Connection connection_;
  client::SensorStream stream_;
  mutable std::mutex mutex_;
  std::condition_variable answered_;
  std::vector<FrameAnswer> answers_;
  std::size_t answer_count_ = 0;
  bool is_over_ = false;
  std::thread reader_;
};

// The times of frames that are sent at the pace of their stamps.
class Pace {
 public:
  explicit Pace(double first_stamp_s) : first_stamp_s_(first_stamp_s) {}
  // Sleeps until the frame of this stamp is due.
  void WaitFor(double stamp_s) const;

 private:
  const double first_stamp_s_;
  const SteadyClock::time_point start_ = SteadyClock::now();
};

}  // namespace cwm::benchmarks
