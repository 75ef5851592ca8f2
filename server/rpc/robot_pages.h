// Lists of robots in pages that all show one revision.
#pragma once

#include "absl/status/status.h"
#include "cwm/v1/robot.pb.h"
#include "server/rpc/call.h"

namespace cwm::server {

// As ListPage of objects: until the page is full by count or by bytes. A name that the request
// gives and the world does not have is NotFound ROBOT_UNKNOWN.
absl::Status ListPage(Runtime& runtime, const v1::ListRobotsRequest& request,
                      const CallContext& call, v1::ListRobotsResponse* response);

}  // namespace cwm::server
