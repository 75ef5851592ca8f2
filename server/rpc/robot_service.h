// cwm.v1.RobotService.
#pragma once

#include "cwm/v1/robot.grpc.pb.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

// Messages of raw methods are parsed by our own code (messages.h).
using RawRobotService = v1::RobotService::WithRawCallbackMethod_ListRobots<
    v1::RobotService::WithRawCallbackMethod_GetRobotLinks<
        v1::RobotService::WithRawCallbackMethod_GetLinkPoses<
            v1::RobotService::WithRawCallbackMethod_DeleteRobot<
                v1::RobotService::WithRawCallbackMethod_LoadRobot<
                    v1::RobotService::WithRawCallbackMethod_StreamRobotStates<
                        v1::RobotService::Service>>>>>>;

class RobotService final : public RawRobotService {
 public:
  explicit RobotService(Runtime& runtime) : runtime_(runtime) {}

  grpc::ServerReadReactor<grpc::ByteBuffer>* LoadRobot(grpc::CallbackServerContext* context,
                                                       grpc::ByteBuffer* response) override;
  grpc::ServerReadReactor<grpc::ByteBuffer>* StreamRobotStates(grpc::CallbackServerContext* context,
                                                               grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListRobots(grpc::CallbackServerContext* context,
                                       const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetRobotLinks(grpc::CallbackServerContext* context,
                                          const grpc::ByteBuffer* request,
                                          grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetLinkPoses(grpc::CallbackServerContext* context,
                                         const grpc::ByteBuffer* request,
                                         grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* DeleteRobot(grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;

 private:
  Runtime& runtime_;
};

}  // namespace cwm::server
