// A world as a file of another tool, in chunks.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <stop_token>
#include <string>

#include "cwm/v1/world.grpc.pb.h"
#include "server/rpc/call.h"

namespace cwm::server {

// Deletes itself when gRPC is done with it.
class ExportWorldCall final : public grpc::ServerWriteReactor<v1::ExportWorldResponse> {
 public:
  ExportWorldCall(grpc::CallbackServerContext* context, Runtime& runtime,
                  const v1::ExportWorldRequest& request);

 private:
  void OnWriteDone(bool ok) override;
  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override;

  void Await();
  void Enqueue();
  void Open();
  absl::Status Format(const CallContext& call);
  void WriteNext();

  Runtime& runtime_;
  const v1::ExportWorldRequest request_;
  const bool counted_ = runtime_.streams.TryTake();
  std::stop_source stop_;
  CallContext call_;
  std::string bytes_;
  std::size_t offset_ = 0;
  std::vector<std::string> warnings_;
  v1::ExportWorldResponse message_;
};

}  // namespace cwm::server
