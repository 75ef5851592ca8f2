// The names that there are on the server, for completion and for what somebody may have meant.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "clients/cli/session.h"

namespace cwm::cli {

enum class Named { kObject, kRobot, kWorld };

// What one page of a list has at most.
inline constexpr std::size_t kMostNames = 10'000;

// At most kMostNames; empty where the server does not answer within half a second.
std::vector<std::string> KnownNames(const Session& session, Named what);

}  // namespace cwm::cli
