// A cloud through IngestCloud, timed.
#pragma once

#include <grpcpp/channel.h>

#include <memory>
#include <string>

#include "perception/cloud/point_cloud.h"

namespace cwm::benchmarks {

struct UploadTimes {
  double whole_ms = 0;
  double after_last_byte_ms = 0;
  bool ok = false;
  std::string error;
};

UploadTimes UploadCloud(const std::shared_ptr<grpc::Channel>& channel,
                        const perception::PointCloud& cloud, const std::string& world);

// build/bin/cwm-server beside this benchmark.
std::string ServerProgram();

}  // namespace cwm::benchmarks
