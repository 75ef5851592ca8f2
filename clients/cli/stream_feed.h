// Sends the frames of a sensor and the states of its robots to the server, and reports the answers.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "absl/status/status.h"
#include "clients/cli/bench/interrupt_handler.h"
#include "clients/cli/frame_loader.h"
#include "clients/cli/frame_timeline.h"
#include "clients/cli/progress.h"
#include "clients/cli/session.h"
#include "clients/cli/stream_report.h"
#include "clients/cpp/sensor_stream.h"

namespace cwm::cli {

struct FeedOptions {
  // Sends frames when they are due, answered or not; else each once the one before is answered.
  bool realtime = false;
  // Sends stamps as they are recorded; else moved to the present.
  bool keep_stamps = false;
  bool send_states = true;
  bool quiet = false;
};

class StreamFeed {
 public:
  StreamFeed(Session& session, FrameSource& source, FrameLoader& loader, FeedOptions options);
  ~StreamFeed();

  // Sends everything, until the end, an error, Ctrl-C, or nobody reads the output. What the
  // calibration does not say is taken from the frames and their camera.
  absl::Status Run(const cwm::v1::SensorCalibration& given);

  const StreamReport& report() const { return report_; }

 private:
  using Clock = StreamReport::Clock;
  struct LoadedFrame {
    TimedFrame timed;
    cwm::v1::SensorFrame message;
  };

  // The next frame with its image; none at the end.
  absl::StatusOr<std::optional<LoadedFrame>> LoadNext();
  // Chooses how recorded times become times of this clock.
  void SetClock(const LoadedFrame& first, const cwm::v1::SensorCalibration& calibration);
  absl::Status SendAll(LoadedFrame first);
  // False if the stream is over.
  bool SendFrame(LoadedFrame frame);
  void SendStates(double time_s);
  void OpenStates(const cwm::v1::SensorCalibration& calibration);
  void CloseStates();
  // The next answers, on a thread of their own.
  void ReadAnswers();
  void Report(const cwm::v1::StreamCloudsResponse& answer);

  // Return false if the stream shall end.
  bool WaitForTurn(const LoadedFrame& frame);
  bool WaitForAnswers(std::optional<Clock::time_point> until);
  bool WaitUntil(double unix_s);
  bool IsOver();

  Session& session_;
  FrameSource& source_;
  FrameLoader& loader_;
  const FeedOptions options_;
  const InterruptHandler interrupt_;
  std::unique_ptr<client::SensorStream> stream_;
  std::map<std::string, std::unique_ptr<client::RobotStateStream>> states_;  // by robot
  double stamp_shift_s_ = 0;  // from stamps to Unix time
  double due_shift_s_ = 0;    // from times at which things are due to Unix time

  std::mutex mutex_;  // of the members below
  std::condition_variable answered_;
  std::map<std::int64_t, Clock::time_point> awaited_;  // when a frame was sent
  std::int64_t sent_count_ = 0;
  bool is_over_ = false;
  StreamReport report_;
  std::set<std::string> warned_reasons_;
  Progress progress_;
  Clock::time_point shown_ = {};
};

}  // namespace cwm::cli
