#include "clients/cpp/sensor_stream.h"

#include <utility>

namespace cwm::client {

SensorStream::SensorStream(const Connection& connection, v1::SensorCalibration calibration)
    : stream_(connection.perception().StreamClouds(&context_)) {
  v1::StreamCloudsRequest request;
  *request.mutable_calibration() = std::move(calibration);
  stream_->Write(request);  // if it fails, Finish has the reason
}

SensorStream::~SensorStream() {
  if (end_) return;
  Cancel();
  v1::StreamCloudsResponse ignored;
  while (stream_->Read(&ignored)) {
  }
  static_cast<void>(stream_->Finish());  // nobody waits for the answers any more
}

bool SensorStream::Send(v1::SensorFrame frame) {
  v1::StreamCloudsRequest request;
  *request.mutable_frame() = std::move(frame);
  return stream_->Write(request);
}

void SensorStream::CloseFrames() { stream_->WritesDone(); }

std::optional<v1::StreamCloudsResponse> SensorStream::Next() {
  v1::StreamCloudsResponse response;
  if (!end_ && stream_->Read(&response)) return response;
  static_cast<void>(Finish());
  return std::nullopt;
}

absl::Status SensorStream::Finish() {
  if (!end_) end_ = StatusFromGrpc(stream_->Finish());
  return *end_;
}

RobotStateStream::RobotStateStream(const Connection& connection, v1::RobotStatesHeader header)
    : writer_(connection.robots().StreamRobotStates(&context_, &response_)) {
  v1::StreamRobotStatesRequest request;
  *request.mutable_header() = std::move(header);
  writer_->Write(request);  // if it fails, Finish has the reason
}

RobotStateStream::~RobotStateStream() {
  if (is_finished_) return;
  Cancel();
  static_cast<void>(writer_->Finish());  // nobody waits for the summary any more
}

bool RobotStateStream::Send(v1::RobotStateRows states) {
  v1::StreamRobotStatesRequest request;
  *request.mutable_states() = std::move(states);
  return writer_->Write(request);
}

absl::StatusOr<v1::StreamRobotStatesResponse> RobotStateStream::Finish() {
  writer_->WritesDone();
  is_finished_ = true;
  absl::Status status = StatusFromGrpc(writer_->Finish());
  if (!status.ok()) return status;
  return response_;
}

}  // namespace cwm::client
