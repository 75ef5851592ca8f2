// The order and the times in which the frames and the robot's states of a sequence are sent.
#pragma once

#include <cstddef>
#include <istream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/formats/frame_sequence.h"

namespace cwm::cli {

// Times are seconds of the recording's clock.
struct TimedFrame {
  formats::SequenceFrame frame;
  std::optional<double> stamp_s = {};  // absent: the time at which it is sent
  double due_s = 0;                    // when it is sent
};
struct TimedState {
  const formats::SequenceState* state = nullptr;
  double stamp_s = 0;
  double due_s = 0;
};

// The first and the last time of a sequence, its rounds included.
struct TimeSpan {
  double begin_s = 0;
  double end_s = 0;
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // The next frame; none at the end. Waits for one that is still to be named.
  virtual absl::StatusOr<std::optional<TimedFrame>> NextFrame() = 0;
  // The next state that is due by `time_s`; none if there is no such state.
  virtual std::optional<TimedState> NextState(double /*time_s*/) { return std::nullopt; }
  // The time of the next state; none after the last.
  virtual std::optional<double> NextStateDue() const { return std::nullopt; }
  // Absent: nobody knows when the frames will end.
  virtual std::optional<TimeSpan> stamps() const { return std::nullopt; }
  // The robots of the states, one state of each; their states all have its variables.
  virtual std::vector<const formats::SequenceState*> robots() const { return {}; }
};

// A folder's sequence, `rounds` times. Frames without stamps are 1 / rate_hz apart. A usage error
// for a rate beside stamps; INVALID_ARGUMENT if some frames have a stamp and others none, or states
// of a robot differ in their variables.
absl::StatusOr<std::unique_ptr<FrameSource>> MakeFolderSource(formats::FrameSequence sequence,
                                                              std::optional<double> rate_hz,
                                                              int rounds);

// Frames by the lines of a stream, see formats::ParseFrameLine, read when they are needed. Those
// without a stamp get the time at which they are sent, or with a rate are 1 / rate_hz apart.
std::unique_ptr<FrameSource> MakeListSource(std::istream& lines, const std::string& name,
                                            std::optional<double> rate_hz);

}  // namespace cwm::cli
