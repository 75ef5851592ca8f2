// Lists robots in pages that all show the same revision.
#pragma once

#include "absl/status/status.h"
#include "cwm/v1/robot.pb.h"
#include "server/rpc/call.h"

namespace cwm::server {

// Like ListPage of objects: until the page is full by count or bytes. NotFound ROBOT_UNKNOWN if the
// request gives a name that the world does not have.
absl::Status ListPage(Runtime& runtime, const v1::ListRobotsRequest& request,
                      const CallContext& call, v1::ListRobotsResponse* response);

}  // namespace cwm::server
