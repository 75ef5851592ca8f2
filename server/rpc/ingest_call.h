// The upload of a cloud: header, chunks, finish, then the work.
#pragma once

#include <optional>
#include <string>

#include "cwm/v1/perception.pb.h"
#include "proto/transfer/sha256.h"
#include "server/rpc/upload.h"
#include "server/rpc/upload_call.h"
#include "server/wire/clouds.h"

namespace cwm::server {

class IngestCall final : public UploadCall<v1::IngestCloudRequest, v1::IngestCloudResponse> {
 public:
  using UploadCall::UploadCall;

 private:
  absl::Status Take(const v1::IngestCloudRequest& message) override;
  absl::Status TakeHeader(const v1::IngestCloudHeader& header);
  absl::Status TakeChunk(const v1::CloudChunk& chunk);
  absl::Status TakeFinish(const v1::CloudFinish& finish);
  absl::Status CheckEnd() const override;
  absl::Status Work() override;
  absl::Status Interpret();
  WorkQueue& Queue() override { return runtime_.ingest; }
  double Cost_s() const override;
  absl::StatusOr<IngestRequest> MakeRequest();
  void KeepScan(World& world, const IngestRequest& request, const IngestOutcome& outcome);

  v1::IngestCloudHeader header_;
  std::optional<CloudPlan> plan_;  // set by the header
  std::optional<Upload> upload_;
  MemoryCharge work_;  // for the interpreter
  Sha256 received_;    // hash of the received bytes
  const Clock::time_point begin_ = Clock::now();
  IngestLine line_;        // the log's line, filled as far as known
  std::string sha256_;     // that the client expects; may be empty
  bool finished_ = false;  // the finish message was received
};

}  // namespace cwm::server
