// One upload of a cloud: header, chunks, finish, then the work.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <stop_token>

#include "cwm/v1/perception.grpc.pb.h"
#include "proto/transfer/sha256.h"
#include "server/rpc/call.h"
#include "server/rpc/received.h"
#include "server/rpc/upload.h"
#include "server/wire/clouds.h"

namespace cwm::server {

// Deletes itself when gRPC is done with it. Reads happen one at a time; once the last has come, the
// ingest queue's task owns the call.
class IngestCall final : public grpc::ServerReadReactor<Received<v1::IngestCloudRequest>> {
 public:
  IngestCall(grpc::CallbackServerContext* context, Runtime& runtime,
             v1::IngestCloudResponse* response);

 private:
  void OnReadDone(bool ok) override;
  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override { delete this; }

  absl::Status Take(const Received<v1::IngestCloudRequest>& received);
  absl::Status TakeHeader(const v1::IngestCloudHeader& header);
  absl::Status TakeChunk(const v1::CloudChunk& chunk);
  absl::Status TakeFinish(const v1::CloudFinish& finish);
  absl::Status CheckEnd() const;
  void Enqueue();
  absl::Status Work();
  absl::Status Interpret();
  absl::StatusOr<IngestRequest> MakeRequest();
  void KeepScan(World& world, const IngestRequest& request, const IngestOutcome& outcome);

  Runtime& runtime_;
  v1::IngestCloudResponse* const response_;
  const Clock::time_point begin_ = Clock::now();
  std::stop_source stop_;
  const CallContext call_;  // its stop is stop_'s
  Received<v1::IngestCloudRequest> message_;
  v1::IngestCloudHeader header_;
  std::optional<CloudPlan> plan_;  // once the header came
  std::optional<Upload> upload_;
  Sha256 received_;        // of the bytes that came
  std::string sha256_;     // that the client expects, or empty
  bool finished_ = false;  // the finish message came
  IngestLine line_;        // of the log, as far as it is known
};

}  // namespace cwm::server
