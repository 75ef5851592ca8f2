// Frames of a running sensor, and states of a running robot, over streams of the server.
#pragma once

#include <grpcpp/client_context.h>

#include <memory>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "cwm/v1/perception.pb.h"
#include "cwm/v1/robot.pb.h"

namespace cwm::client {

// One thread may send while another reads. The connection must outlive the stream, which has no
// deadline; the destructor cancels a stream that was not read to its end.
class SensorStream {
 public:
  SensorStream(const Connection& connection, v1::SensorCalibration calibration);
  ~SensorStream();
  SensorStream(const SensorStream&) = delete;
  SensorStream& operator=(const SensorStream&) = delete;

  // False if the stream is over, for the reason that Finish returns.
  bool Send(v1::SensorFrame frame);
  // Sends nothing more; the frames that were sent are still answered.
  void CloseFrames();
  // Waits for the next answer; none at the end of the stream.
  std::optional<v1::StreamCloudsResponse> Next();
  // The end of the stream, once Next returned nothing: OK after CloseFrames.
  absl::Status Finish();
  // Ends the stream at once, from any thread.
  void Cancel() { context_.TryCancel(); }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamCloudsRequest, v1::StreamCloudsResponse>>
      stream_;
  std::optional<absl::Status> end_;
};

// For one thread; Cancel from any. The connection must outlive the stream.
class RobotStateStream {
 public:
  RobotStateStream(const Connection& connection, v1::RobotStatesHeader header);
  ~RobotStateStream();
  RobotStateStream(const RobotStateStream&) = delete;
  RobotStateStream& operator=(const RobotStateStream&) = delete;

  // False if the stream is over, for the reason that Finish returns.
  bool Send(v1::RobotStateRows states);
  // Ends the stream and returns the server's summary.
  absl::StatusOr<v1::StreamRobotStatesResponse> Finish();
  void Cancel() { context_.TryCancel(); }

 private:
  grpc::ClientContext context_;
  v1::StreamRobotStatesResponse response_;
  std::unique_ptr<grpc::ClientWriter<v1::StreamRobotStatesRequest>> writer_;
  bool is_finished_ = false;
};

}  // namespace cwm::client
