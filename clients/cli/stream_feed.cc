#include "clients/cli/stream_feed.h"

#include <google/protobuf/util/time_util.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cli/closed_pipe.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;
using std::chrono::milliseconds;

// chosen: how soon an interrupt is noticed.
constexpr milliseconds kPollPeriod(50);
// chosen: the line is read by people.
constexpr milliseconds kShowPeriod(100);
// chosen: after an interrupt the frames on their way are answered in this time.
constexpr milliseconds kLastAnswers(2'000);
// derived: half of how far in the future the server takes stamps, 1 s.
constexpr double kMaxAheadS = 0.5;

double NowUnix() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

google::protobuf::Timestamp ToTimestamp(double unix_s) {
  return google::protobuf::util::TimeUtil::NanosecondsToTimestamp(std::llround(unix_s * 1e9));
}

// The stamp of the sensor's newest frame, which newer ones must exceed; none if it is new.
std::optional<double> LastFrameOf(const client::Connection& connection,
                                  const pb::SensorCalibration& calibration) {
  pb::ListSensorsRequest request;
  request.set_world(calibration.world());
  const auto listed =
      connection.Call(&pb::PerceptionService::Stub::ListSensors, connection.perception(), request);
  if (!listed.ok()) return std::nullopt;  // the world may be new
  for (const pb::Sensor& sensor : listed->sensors()) {
    if (sensor.name() != calibration.sensor() || !sensor.has_last_frame()) continue;
    return 1e-9 * static_cast<double>(google::protobuf::util::TimeUtil::TimestampToNanoseconds(
                      sensor.last_frame()));
  }
  return std::nullopt;
}

}  // namespace

StreamFeed::StreamFeed(Session& session, FrameSource& source, FrameLoader& loader,
                       FeedOptions options)
    : session_(session),
      source_(source),
      loader_(loader),
      options_(options),
      progress_(session.streams.err, session.streams.err_is_terminal && !options.quiet
                                         ? ProgressStyle::kOneLine
                                         : ProgressStyle::kSilent) {}

StreamFeed::~StreamFeed() = default;

absl::Status StreamFeed::Run(const pb::SensorCalibration& given) {
  auto first = LoadNext();
  if (!first.ok()) return first.status();
  if (!first->has_value()) return absl::InvalidArgumentError("no frame was named");
  pb::SensorCalibration calibration = loader_.layout();
  calibration.MergeFrom(given);
  SetClock(**first, calibration);
  if (options_.send_states) OpenStates(calibration);
  stream_ = std::make_unique<client::SensorStream>(session_.connection(), calibration);
  std::thread reader([this] { ReadAnswers(); });
  absl::Status status = SendAll(**std::move(first));
  stream_->CloseFrames();
  if (!WaitForAnswers(std::nullopt)) WaitForAnswers(Clock::now() + kLastAnswers);
  const bool is_interrupted = interrupt_.signalled() || !session_.streams.out;
  if (is_interrupted) stream_->Cancel();
  reader.join();
  progress_.Clear();
  CloseStates();
  const absl::Status end = stream_->Finish();
  if (!status.ok() || is_interrupted) return status;
  return end;
}

absl::StatusOr<std::optional<StreamFeed::LoadedFrame>> StreamFeed::LoadNext() {
  auto timed = source_.NextFrame();
  if (!timed.ok()) return timed.status();
  if (!timed->has_value()) return std::nullopt;
  auto message = loader_.Load((*timed)->frame);
  if (!message.ok()) return message.status();
  return LoadedFrame{**std::move(timed), *std::move(message)};
}

void StreamFeed::SetClock(const LoadedFrame& first, const pb::SensorCalibration& calibration) {
  const double now_s = NowUnix();
  due_shift_s_ = now_s - first.timed.due_s;
  if (!first.timed.stamp_s) return;
  if (options_.keep_stamps) return;
  const auto span = source_.stamps();
  const double begin_s = span ? span->begin_s : *first.timed.stamp_s;
  stamp_shift_s_ = due_shift_s_;
  // Faster than they were recorded, the frames of a folder would soon have stamps of the future.
  if (span && !options_.realtime) stamp_shift_s_ = now_s - span->end_s;
  if (const auto last_s = LastFrameOf(session_.connection(), calibration)) {
    constexpr double kNewer = 1e-3;  // chosen: far above the rounding of times
    stamp_shift_s_ = std::max(stamp_shift_s_, *last_s + kNewer - begin_s);
  }
}

absl::Status StreamFeed::SendAll(LoadedFrame first) {
  for (std::optional<LoadedFrame> frame = std::move(first); frame;) {
    if (!WaitForTurn(*frame) || !SendFrame(*std::move(frame))) return absl::OkStatus();
    auto next = LoadNext();  // while the server works
    if (!next.ok()) return next.status();
    frame = *std::move(next);
  }
  return absl::OkStatus();
}

bool StreamFeed::SendFrame(LoadedFrame frame) {
  const double stamp_s = frame.timed.stamp_s ? *frame.timed.stamp_s + stamp_shift_s_ : NowUnix();
  *frame.message.mutable_frame_stamp() = ToTimestamp(stamp_s);
  {
    const std::lock_guard lock(mutex_);
    awaited_[sent_count_++] = Clock::now();
  }
  return stream_->Send(std::move(frame.message));
}

void StreamFeed::OpenStates(const pb::SensorCalibration& calibration) {
  for (const formats::SequenceState* robot : source_.robots()) {
    pb::RobotStatesHeader header;
    header.set_world(calibration.world());
    header.set_robot(robot->robot);
    header.mutable_variables()->Assign(robot->variables.begin(), robot->variables.end());
    states_[robot->robot] =
        std::make_unique<client::RobotStateStream>(session_.connection(), std::move(header));
  }
}

void StreamFeed::SendStates(double time_s) {
  std::map<std::string, pb::RobotStateRows> rows;
  while (const auto timed = source_.NextState(time_s)) {
    const std::vector<double>& values = timed->state->values;
    pb::RobotStateRows& batch = rows[timed->state->robot];
    *batch.add_stamps() = ToTimestamp(timed->stamp_s + stamp_shift_s_);
    batch.mutable_rows()->set_scalar(pb::SCALAR_F64);
    batch.mutable_rows()->set_width(static_cast<int>(values.size()));
    batch.mutable_rows()->mutable_data()->append(reinterpret_cast<const char*>(values.data()),
                                                 values.size() * sizeof(double));
  }
  for (auto& [robot, batch] : rows) {
    const auto stream = states_.find(robot);
    if (stream == states_.end() || stream->second->Send(std::move(batch))) continue;
    const auto end = stream->second->Finish();
    const std::lock_guard lock(mutex_);  // answers are printed meanwhile
    progress_.Clear();
    session_.Warn(absl::StrCat("the states of the robot ", robot,
                               " are no longer sent: ", std::string(end.status().message())));
    states_.erase(stream);
  }
}

void StreamFeed::CloseStates() {
  for (auto& [robot, stream] : states_) {
    const auto end = stream->Finish();
    if (end.ok()) continue;
    session_.Warn(absl::StrCat("the states of the robot ", robot,
                               " were not taken: ", std::string(end.status().message())));
  }
  states_.clear();
}

void StreamFeed::ReadAnswers() {
  while (const auto answer = stream_->Next()) Report(*answer);
  const std::lock_guard lock(mutex_);
  is_over_ = true;
  answered_.notify_all();
}

void StreamFeed::Report(const pb::StreamCloudsResponse& answer) {
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  const auto sent = awaited_.find(answer.frame());
  report_.Add(answer, sent == awaited_.end() ? Clock::duration(0) : now - sent->second, now);
  if (sent != awaited_.end()) awaited_.erase(sent);
  answered_.notify_all();
  if (session_.form != OutputForm::kTable && !options_.quiet) {
    session_.PrintLine(answer);
    session_.streams.out.flush();
  }
  if (!answer.reason().empty() && warned_reasons_.insert(answer.reason()).second) {
    progress_.Clear();
    session_.Warn(
        absl::StrCat("frame ", answer.frame(), ": ", answer.reason(), ": ", answer.message()));
  }
  if (now - shown_ < kShowPeriod) return;
  shown_ = now;
  progress_.ShowStage(report_.Line());
}

bool StreamFeed::IsOver() {
  if (interrupt_.signalled()) return true;
  const std::lock_guard lock(mutex_);
  return is_over_ || !session_.streams.out || IsPipeClosed(session_.streams.out);
}

bool StreamFeed::WaitUntil(double unix_s) {
  while (!IsOver()) {
    const double left_s = unix_s - NowUnix();
    if (left_s <= 0) return true;
    std::this_thread::sleep_for(std::min(std::chrono::duration<double>(left_s),
                                         std::chrono::duration<double>(kPollPeriod)));
  }
  return false;
}

bool StreamFeed::WaitForAnswers(std::optional<Clock::time_point> until) {
  while (until ? Clock::now() < *until : !IsOver()) {
    std::unique_lock lock(mutex_);
    if (awaited_.empty()) return true;
    if (is_over_) return false;
    answered_.wait_for(lock, kPollPeriod);
  }
  return false;
}

bool StreamFeed::WaitForTurn(const LoadedFrame& frame) {
  if (options_.realtime) {
    // States have times of their own between the frames.
    while (const auto state_due_s = source_.NextStateDue()) {
      if (*state_due_s > frame.timed.due_s) break;
      if (!WaitUntil(*state_due_s + due_shift_s_)) return false;
      SendStates(*state_due_s);
    }
    return WaitUntil(frame.timed.due_s + due_shift_s_);
  }
  if (!WaitForAnswers(std::nullopt)) return false;
  SendStates(frame.timed.due_s);
  if (!frame.timed.stamp_s || options_.keep_stamps) return true;
  return WaitUntil(*frame.timed.stamp_s + stamp_shift_s_ - kMaxAheadS);
}

}  // namespace cwm::cli
