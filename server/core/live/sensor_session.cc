#include "server/core/live/sensor_session.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

absl::Status TakenOver(const std::string& sensor) {
  return MakeError(absl::StatusCode::kAborted,
                   absl::StrCat("another stream of the sensor \"", sensor, "\" took over"),
                   {.reason = "SENSOR_TAKEN_OVER", .metadata = {{"sensor", sensor}}});
}

}  // namespace

SensorSession::SensorSession(SensorCalibration calibration)
    : calibration_(std::move(calibration)) {}

std::uint64_t SensorSession::Begin(SensorCalibration calibration, EndStream end) {
  EndStream previous;
  std::uint64_t number = 0;
  const absl::Status reason = TakenOver(calibration.sensor);
  {
    const std::lock_guard lock(mutex_);
    calibration_ = std::move(calibration);
    previous = std::exchange(end_, std::move(end));
    number = open_stream_ = ++last_stream_;
    last_active_ = Clock::now();
  }
  if (previous) previous(reason);
  return number;
}

void SensorSession::End(std::uint64_t stream, Clock::time_point now) {
  EndStream dropped;  // freed without the lock
  const std::lock_guard lock(mutex_);
  if (stream != open_stream_) return;
  open_stream_ = 0;
  dropped = std::exchange(end_, {});
  last_active_ = now;
}

absl::Status SensorSession::CheckOwner(std::uint64_t stream) const {
  const std::lock_guard lock(mutex_);
  return stream == open_stream_ ? absl::OkStatus() : TakenOver(calibration_.sensor);
}

void SensorSession::EndOpenStream(const absl::Status& reason) {
  EndStream end;
  {
    const std::lock_guard lock(mutex_);
    open_stream_ = 0;
    end = std::exchange(end_, {});
  }
  if (end) end(reason);
}

SensorCalibration SensorSession::calibration() const {
  const std::lock_guard lock(mutex_);
  return calibration_;
}

void SensorSession::SetPose(const Pose& X_WC) {
  const std::lock_guard lock(mutex_);
  calibration_.X_WC = X_WC;
}

std::optional<SensorSession::FailedEstimate> SensorSession::failed_estimate() const {
  const std::lock_guard lock(mutex_);
  return failed_estimate_;
}

void SensorSession::set_failed_estimate(std::optional<FailedEstimate> failed) {
  const std::lock_guard lock(mutex_);
  failed_estimate_ = std::move(failed);
}

void SensorSession::NoteProcessed(std::shared_ptr<const DisplayFrame> frame, double delay_ms) {
  const Clock::time_point now = Clock::now();
  const std::lock_guard lock(mutex_);
  statistics_.NoteProcessed(now, frame->latency_ms, delay_ms);
  newest_.swap(frame);
  last_active_ = now;
}

void SensorSession::NoteDropped() {
  const std::lock_guard lock(mutex_);
  statistics_.NoteDropped();
}

void SensorSession::NoteRefused() {
  const std::lock_guard lock(mutex_);
  statistics_.NoteRefused();
}

SensorStatus SensorSession::status(Clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  SensorStatus status{.calibration = calibration_, .is_streaming = open_stream_ != 0};
  statistics_.Fill(now, status);
  if (newest_ != nullptr) {
    status.X_WC = newest_->X_WC;
    status.last_frame = newest_->stamp;
  }
  return status;
}

std::shared_ptr<const DisplayFrame> SensorSession::newest_frame() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

bool SensorSession::is_streaming() const {
  const std::lock_guard lock(mutex_);
  return open_stream_ != 0;
}

Clock::time_point SensorSession::last_active() const {
  const std::lock_guard lock(mutex_);
  return last_active_;
}

bool SensorSession::is_tracked() const {
  const std::lock_guard lock(mutex_);
  return is_tracked_;
}

void SensorSession::set_tracked(bool is_tracked) {
  const std::lock_guard lock(mutex_);
  is_tracked_ = is_tracked;
}

void SensorSession::Hold(MemoryCharge view) {
  const std::lock_guard lock(mutex_);
  std::swap(view_, view);  // the earlier one is released without the lock
}

void SensorSession::Forget() {
  std::shared_ptr<const DisplayFrame> dropped;
  MemoryCharge view;
  const std::lock_guard lock(mutex_);
  dropped.swap(newest_);
  std::swap(view, view_);
}

}  // namespace cwm::server
