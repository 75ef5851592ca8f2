// cwm.v1.QueryService.
#pragma once

#include "cwm/v1/query.grpc.pb.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

// Messages of raw methods are parsed by our own code (messages.h).
using RawQueryService = v1::QueryService::WithRawCallbackMethod_CheckCollisions<
    v1::QueryService::WithRawCallbackMethod_GetDistances<
        v1::QueryService::WithRawCallbackMethod_GetContacts<
            v1::QueryService::WithRawCallbackMethod_CheckMotions<
                v1::QueryService::WithRawCallbackMethod_CastRays<
                    v1::QueryService::WithRawCallbackMethod_SamplePoints<
                        v1::QueryService::WithRawCallbackMethod_SolvePoses<
                            v1::QueryService::WithRawCallbackMethod_GetWorldContacts<
                                v1::QueryService::WithRawCallbackMethod_StreamQueries<
                                    v1::QueryService::Service>>>>>>>>>;

class QueryService final : public RawQueryService {
 public:
  explicit QueryService(Runtime& runtime) : runtime_(runtime) {}

  grpc::ServerUnaryReactor* CheckCollisions(grpc::CallbackServerContext* context,
                                            const grpc::ByteBuffer* request,
                                            grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetDistances(grpc::CallbackServerContext* context,
                                         const grpc::ByteBuffer* request,
                                         grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetContacts(grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* CheckMotions(grpc::CallbackServerContext* context,
                                         const grpc::ByteBuffer* request,
                                         grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetWorldContacts(grpc::CallbackServerContext* context,
                                             const grpc::ByteBuffer* request,
                                             grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* CastRays(grpc::CallbackServerContext* context,
                                     const grpc::ByteBuffer* request,
                                     grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* SamplePoints(grpc::CallbackServerContext* context,
                                         const grpc::ByteBuffer* request,
                                         grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* SolvePoses(grpc::CallbackServerContext* context,
                                       const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* StreamQueries(
      grpc::CallbackServerContext* context) override;

 private:
  Runtime& runtime_;
};

}  // namespace cwm::server
