// The names that there are on the server, for completion and for what somebody may have meant.
#pragma once

#include <string>
#include <vector>

#include "clients/cli/session.h"

namespace cwm::cli {

enum class Named { kObject, kRobot, kWorld };

// At most ten thousand; empty where the server does not answer within half a second.
std::vector<std::string> KnownNames(const Session& session, Named what);

}  // namespace cwm::cli
