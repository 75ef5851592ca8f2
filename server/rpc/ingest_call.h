// One upload of a cloud: header, chunks, finish, then the work.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>

#include "cwm/v1/perception.grpc.pb.h"
#include "proto/transfer/sha256.h"
#include "server/rpc/upload.h"
#include "server/rpc/upload_call.h"
#include "server/wire/clouds.h"

namespace cwm::server {

// The work is the ingest queue's.
class IngestCall final : public UploadCall<v1::IngestCloudRequest> {
 public:
  IngestCall(grpc::CallbackServerContext* context, Runtime& runtime,
             v1::IngestCloudResponse* response);

 private:
  void OnMessage(bool ok) override;

  absl::Status Take(const v1::IngestCloudRequest& message);
  absl::Status TakeHeader(const v1::IngestCloudHeader& header);
  absl::Status TakeChunk(const v1::CloudChunk& chunk);
  absl::Status TakeFinish(const v1::CloudFinish& finish);
  absl::Status CheckEnd() const;
  void Enqueue();
  absl::Status Work();
  absl::StatusOr<IngestRequest> MakeRequest();
  void KeepScan(World& world, const IngestRequest& request, const IngestOutcome& outcome);

  v1::IngestCloudResponse* const response_;
  const CallContext call_;  // its stop is stop_'s
  v1::IngestCloudHeader header_;
  std::optional<CloudPlan> plan_;  // once the header came
  std::optional<Upload> upload_;
  Sha256 received_;        // of the bytes that came
  std::string sha256_;     // that the client expects, or empty
  bool finished_ = false;  // the finish message came
};

}  // namespace cwm::server
