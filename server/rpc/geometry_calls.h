// Reads and writes blobs by their hash, in chunks.
#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <memory>
#include <optional>

#include "cwm/v1/world.grpc.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/chunked_read.h"
#include "server/rpc/upload.h"
#include "server/rpc/upload_call.h"

namespace cwm::server {

class ReadGeometryCall final : public ChunkedRead<v1::ReadGeometryResponse> {
 public:
  ReadGeometryCall(grpc::CallbackServerContext* context, Runtime& runtime,
                   const grpc::ByteBuffer* request);

 private:
  absl::Status Prepare(const CallContext& call) override;
  void Complete(v1::ReadGeometryResponse& message) override;

  absl::Status FindBlob();
  absl::Status FindSurface(const CallContext& call);
  absl::Status Begin();

  v1::ReadGeometryRequest request_;
};

class WriteGeometryCall final
    : public UploadCall<v1::WriteGeometryRequest, v1::WriteGeometryResponse> {
 public:
  using UploadCall::UploadCall;

 private:
  absl::Status Take(const v1::WriteGeometryRequest& message) override;
  absl::Status TakeHeader(const v1::WriteGeometryRequest::Header& header);
  absl::Status CheckEnd() const override;
  absl::Status Work() override;
  WorkQueue& Queue() override;
  double Cost_s() const override;
  std::function<absl::StatusOr<bool>()> LookUp() override;
  absl::StatusOr<bool> IsKnown();
  void Reply(const GeometryStore::Stored& stored);

  v1::WriteGeometryRequest::Header header_;
  std::optional<Upload> upload_;  // set by the header
  bool is_looked_up_ = false;
};

}  // namespace cwm::server
