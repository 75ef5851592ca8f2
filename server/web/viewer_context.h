// The state that all connections of a viewer share.
#pragma once

#include "server/web/bridge_call.h"
#include "server/web/connection_list.h"
#include "server/web/routes.h"
#include "server/web/viewer_limits.h"

namespace cwm::server {

// Must outlive its connections; used only on the viewer's thread.
struct ViewerContext {
  const ViewerLimits limits;
  const Site site;
  Bridge bridge;
  ConnectionList connections = {};
};

}  // namespace cwm::server
