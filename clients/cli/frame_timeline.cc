#include "clients/cli/frame_timeline.h"

#include <algorithm>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cli/exit_code.h"

namespace cwm::cli {
namespace {

using formats::FrameSequence;
using formats::SequenceFrame;
using formats::SequenceState;

// The rate of most depth cameras.
constexpr double kUsualRateHz = 30;

class FolderSource : public FrameSource {
 public:
  FolderSource(FrameSequence sequence, std::vector<TimedFrame> frames, int rounds)
      : sequence_(std::move(sequence)), frames_(std::move(frames)), rounds_(rounds) {
    span_ = {*frames_[0].stamp_s, *frames_[0].stamp_s};
    TimeSpan due = {frames_[0].due_s, frames_[0].due_s};
    for (const TimedFrame& frame : frames_) {
      span_.begin_s = std::min(span_.begin_s, *frame.stamp_s);
      span_.end_s = std::max(span_.end_s, *frame.stamp_s);
      due.begin_s = std::min(due.begin_s, frame.due_s);
      due.end_s = std::max(due.end_s, frame.due_s);
    }
    // The next round begins one mean interval after the last frame.
    const double gaps = std::max<double>(1, static_cast<double>(frames_.size()) - 1);
    const double longest_s = std::max(span_.end_s - span_.begin_s, due.end_s - due.begin_s);
    round_s_ = frames_.size() > 1 ? longest_s * (1 + 1 / gaps) : 1 / kUsualRateHz;
  }

  absl::StatusOr<std::optional<TimedFrame>> NextFrame() override {
    if (next_frame_ == frames_.size() * static_cast<std::size_t>(rounds_)) return std::nullopt;
    TimedFrame frame = frames_[next_frame_ % frames_.size()];
    const double round_begin_s = BeginOfRound(next_frame_ / frames_.size());
    *frame.stamp_s += round_begin_s;
    frame.due_s += round_begin_s;
    ++next_frame_;
    return frame;
  }

  std::optional<TimedState> NextState(double time_s) override {
    const auto due_s = NextStateDue();
    if (!due_s || *due_s > time_s) return std::nullopt;
    const std::vector<SequenceState>& states = sequence_.states;
    const SequenceState& state = states[next_state_ % states.size()];
    const double round_begin_s = BeginOfRound(next_state_ / states.size());
    ++next_state_;
    return TimedState{.state = &state, .stamp_s = state.stamp_s + round_begin_s, .due_s = *due_s};
  }

  std::optional<double> NextStateDue() const override {
    const std::vector<SequenceState>& states = sequence_.states;
    if (next_state_ == states.size() * static_cast<std::size_t>(rounds_)) return std::nullopt;
    return states[next_state_ % states.size()].delivery_s +
           BeginOfRound(next_state_ / states.size());
  }

  std::optional<TimeSpan> stamps() const override {
    return TimeSpan{span_.begin_s,
                    span_.end_s + BeginOfRound(static_cast<std::size_t>(rounds_) - 1)};
  }

  std::vector<const SequenceState*> robots() const override {
    std::map<std::string, const SequenceState*> robots;
    for (const SequenceState& state : sequence_.states) robots.emplace(state.robot, &state);
    std::vector<const SequenceState*> list;
    for (const auto& [name, state] : robots) list.push_back(state);
    return list;
  }

 private:
  double BeginOfRound(std::size_t round) const { return static_cast<double>(round) * round_s_; }

  const FrameSequence sequence_;
  const std::vector<TimedFrame> frames_;
  const int rounds_;
  TimeSpan span_;       // of the stamps of a round
  double round_s_ = 0;  // from the begin of a round to that of the next
  std::size_t next_frame_ = 0, next_state_ = 0;
};

absl::Status CheckStates(const std::vector<SequenceState>& states) {
  std::map<std::string, const SequenceState*> first_of;
  for (const SequenceState& state : states) {
    const SequenceState& first = *first_of.emplace(state.robot, &state).first->second;
    if (state.variables == first.variables && state.values.size() == first.values.size()) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(state.source, ": names are not those of ", first.source,
                     ", must be the same in all states of the robot ", state.robot));
  }
  return absl::OkStatus();
}

class ListSource : public FrameSource {
 public:
  ListSource(std::istream& lines, std::string name, std::optional<double> rate_hz)
      : lines_(lines), name_(std::move(name)), rate_hz_(rate_hz) {}

  absl::StatusOr<std::optional<TimedFrame>> NextFrame() override {
    std::string line;
    while (std::getline(lines_, line)) {
      const std::string source = absl::StrCat(name_, ":", ++line_count_);
      auto frame = formats::ParseFrameLine(line, "", source);
      if (!frame.ok()) return frame.status();
      if (frame->has_value()) return Timed(**std::move(frame));
    }
    return std::nullopt;
  }

 private:
  absl::StatusOr<std::optional<TimedFrame>> Timed(SequenceFrame frame) {
    TimedFrame timed{.frame = std::move(frame)};
    timed.stamp_s = timed.frame.stamp_s;
    if (rate_hz_) {
      if (timed.stamp_s) {
        return UsageError(
            absl::StrCat("--rate is for frames without stamps; ", timed.frame.source, " has one"));
      }
      timed.stamp_s = static_cast<double>(frame_count_) / *rate_hz_;
    }
    if (frame_count_++ == 0) has_stamps_ = timed.stamp_s.has_value();
    if (timed.stamp_s.has_value() != has_stamps_) {
      return absl::InvalidArgumentError(
          absl::StrCat(timed.frame.source, ": the frame has ", has_stamps_ ? "no" : "a",
                       " stamp, must have ", has_stamps_ ? "one" : "none", " like the first one"));
    }
    timed.due_s = timed.frame.delivery_s.value_or(timed.stamp_s.value_or(0));
    return timed;
  }

  std::istream& lines_;
  const std::string name_;
  const std::optional<double> rate_hz_;
  std::int64_t line_count_ = 0, frame_count_ = 0;
  bool has_stamps_ = false;
};

}  // namespace

absl::StatusOr<std::unique_ptr<FrameSource>> MakeFolderSource(FrameSequence sequence,
                                                              std::optional<double> rate_hz,
                                                              int rounds) {
  const bool has_stamps = sequence.frames.at(0).stamp_s.has_value();
  if (has_stamps && rate_hz) {
    return UsageError(absl::StrCat("--rate is for frames without stamps; ",
                                   sequence.frames[0].source, " has one"));
  }
  std::vector<TimedFrame> frames;
  for (const SequenceFrame& frame : sequence.frames) {
    if (frame.stamp_s.has_value() != has_stamps) {
      return absl::InvalidArgumentError(
          absl::StrCat(frame.source, ": stamp is missing, must be there in all frames or in none"));
    }
    const double index_s = static_cast<double>(frames.size()) / rate_hz.value_or(kUsualRateHz);
    const double stamp_s = frame.stamp_s.value_or(index_s);
    frames.push_back({frame, stamp_s, frame.delivery_s.value_or(stamp_s)});
  }
  if (absl::Status status = CheckStates(sequence.states); !status.ok()) return status;
  return std::make_unique<FolderSource>(std::move(sequence), std::move(frames), rounds);
}

std::unique_ptr<FrameSource> MakeListSource(std::istream& lines, const std::string& name,
                                            std::optional<double> rate_hz) {
  return std::make_unique<ListSource>(lines, name, rate_hz);
}

}  // namespace cwm::cli
