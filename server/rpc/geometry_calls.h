// Blobs by their hash, out and in, in chunks.
#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>

#include "cwm/v1/world.grpc.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/upload.h"

namespace cwm::server {

// Both delete themselves when gRPC is done with them.
class ReadGeometryCall final : public grpc::ServerWriteReactor<v1::ReadGeometryResponse> {
 public:
  ReadGeometryCall(grpc::CallbackServerContext* context, Runtime& runtime,
                   const v1::ReadGeometryRequest& request);

 private:
  void OnWriteDone(bool ok) override;
  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override { delete this; }

  void Await();
  void Enqueue();
  void Open();
  absl::Status Find(const CallContext& call);
  absl::Status FindBlob();
  absl::Status FindSurface(const CallContext& call);
  absl::Status Begin();
  void WriteNext();

  Runtime& runtime_;
  const v1::ReadGeometryRequest request_;
  std::stop_source stop_;
  CallContext call_;
  std::shared_ptr<const std::string> bytes_;
  std::size_t offset_ = 0;
  v1::ReadGeometryResponse message_;
};

class WriteGeometryCall final : public grpc::ServerReadReactor<v1::WriteGeometryRequest> {
 public:
  WriteGeometryCall(Runtime& runtime, v1::WriteGeometryResponse* response);

 private:
  void OnReadDone(bool ok) override;
  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override { delete this; }

  absl::Status Take(const v1::WriteGeometryRequest& message);
  absl::Status TakeHeader(const v1::WriteGeometryRequest::Header& header);
  absl::Status CheckEnd() const;
  // `work` finishes the call.
  void Enqueue(std::function<void()> work);
  void LookUp();
  absl::StatusOr<bool> IsKnown();
  absl::Status Store();
  void Reply(const GeometryStore::Stored& stored);

  Runtime& runtime_;
  v1::WriteGeometryResponse* const response_;
  std::stop_source stop_;
  v1::WriteGeometryRequest message_;
  v1::WriteGeometryRequest::Header header_;
  std::optional<Upload> upload_;  // once the header came
};

}  // namespace cwm::server
