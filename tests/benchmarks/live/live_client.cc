#include "tests/benchmarks/live/live_client.h"

#include <algorithm>
#include <utility>

#include "tests/benchmarks/running_server.h"

namespace cwm::benchmarks {
namespace {

constexpr auto kPatience = std::chrono::seconds(20);

}  // namespace

v1::SensorCalibration CalibrationOf(const std::string& world, const std::string& sensor,
                                    const RecordedFrame& frame, bool is_fixed) {
  v1::SensorCalibration calibration;
  calibration.set_world(world);
  calibration.set_sensor(sensor);
  calibration.mutable_sensor_model()->set_kind(v1::SensorModel::KIND_KINECT);
  if (is_fixed) SetPose(frame.X_WC, calibration.mutable_x_world_sensor());
  *calibration.mutable_depth() = LayoutOf(frame);
  return calibration;
}

LiveSensor::LiveSensor(const std::string& address, v1::SensorCalibration calibration)
    : is_fixed_(calibration.has_x_world_sensor()),
      connection_({.address = address, .deadline = std::nullopt}),
      stream_(connection_, std::move(calibration)),
      reader_([this] { Read(); }) {}

LiveSensor::~LiveSensor() {
  stream_.Cancel();
  if (reader_.joinable()) reader_.join();
}

void LiveSensor::Read() {
  while (auto response = stream_.Next()) {
    const auto now = SteadyClock::now();
    const std::lock_guard lock(mutex_);
    const auto index = static_cast<std::size_t>(response->frame());
    if (index >= answers_.size()) continue;  // no frame of ours
    answers_[index].answered = now;
    answers_[index].response = *std::move(response);
    ++answer_count_;
    answered_.notify_all();
  }
  const std::lock_guard lock(mutex_);
  is_over_ = true;
  answered_.notify_all();
}

std::optional<std::size_t> LiveSensor::Send(const RecordedFrame& frame) {
  v1::SensorFrame message = MessageOf(frame, !is_fixed_);
  std::size_t index = 0;
  {
    const std::lock_guard lock(mutex_);
    index = answers_.size();
    answers_.push_back({.begun = SteadyClock::now()});
  }
  const bool is_sent = stream_.Send(std::move(message));
  const std::lock_guard lock(mutex_);
  answers_[index].sent = SteadyClock::now();
  if (!is_sent) return std::nullopt;
  return index;
}

bool LiveSensor::WaitForAnswers(std::size_t count, std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  answered_.wait_for(lock, patience, [&] { return is_over_ || answer_count_ >= count; });
  return answer_count_ >= count;
}

std::optional<FrameAnswer> LiveSensor::SendAndWait(const RecordedFrame& frame) {
  const auto index = Send(frame);
  if (!index || !WaitForAnswers(*index + 1, kPatience)) return std::nullopt;
  const std::lock_guard lock(mutex_);
  return answers_[*index];
}

std::vector<FrameAnswer> LiveSensor::answers() const {
  const std::lock_guard lock(mutex_);
  return answers_;
}

std::size_t LiveSensor::sent_count() const {
  const std::lock_guard lock(mutex_);
  return answers_.size();
}

std::string LiveSensor::Finish() {
  stream_.CloseFrames();
  if (reader_.joinable()) reader_.join();
  return stream_.Finish().ToString();
}

void Pace::WaitFor(double stamp_s) const {
  std::this_thread::sleep_until(start_ +
                                std::chrono::duration_cast<SteadyClock::duration>(
                                    std::chrono::duration<double>(stamp_s - first_stamp_s_)));
}

}  // namespace cwm::benchmarks
