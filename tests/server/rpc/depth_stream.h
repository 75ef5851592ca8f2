// A sensor's stream into a running server, frame by frame.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cwm/v1/perception.grpc.pb.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {

// The calibration of a small F32 depth camera that looks along the world's x axis from 1 m above
// its origin.
v1::SensorCalibration SmallCamera(const std::string& sensor = "head", int width_px = 64,
                                  int height_px = 48);

// A frame that shows a wall at this depth everywhere.
v1::SensorFrame WallFrame(const v1::SensorCalibration& calibration, float depth_m, double stamp_s);

class DepthStream {
 public:
  explicit DepthStream(v1::PerceptionService::Stub& stub) : stream_(stub.StreamClouds(&call_)) {}

  bool Send(const v1::SensorCalibration& calibration);
  bool Send(const v1::SensorFrame& frame);
  // The next answer; empty after the last one.
  std::optional<v1::StreamCloudsResponse> Next();
  // Sends a frame and waits for its answer.
  v1::StreamCloudsResponse MustProcess(const v1::SensorFrame& frame);
  // No more frames come: the status, after the answers that were not read.
  grpc::Status Finish();
  void WritesDone();

 private:
  Call call_{std::chrono::minutes(2)};
  bool is_done_ = false;  // nothing more is sent
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamCloudsRequest, v1::StreamCloudsResponse>>
      stream_;
};

}  // namespace cwm::server
