// cwm.v1.RobotService.
#pragma once

#include "cwm/v1/robot.grpc.pb.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

class RobotService final : public v1::RobotService::CallbackService {
 public:
  explicit RobotService(Runtime& runtime);

  grpc::ServerUnaryReactor* ListRobots(grpc::CallbackServerContext* context,
                                       const v1::ListRobotsRequest* request,
                                       v1::ListRobotsResponse* response) override;
  grpc::ServerUnaryReactor* GetRobotLinks(grpc::CallbackServerContext* context,
                                          const v1::GetRobotLinksRequest* request,
                                          v1::GetRobotLinksResponse* response) override;
  grpc::ServerUnaryReactor* DeleteRobot(grpc::CallbackServerContext* context,
                                        const v1::DeleteRobotRequest* request,
                                        v1::DeleteRobotResponse* response) override;

 private:
  Runtime& runtime_;
};

}  // namespace cwm::server
