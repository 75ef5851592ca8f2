// Names known to the server, for completion and for corrections.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "clients/cli/session.h"

namespace cwm::cli {

enum class NameKind { kObject, kRobot, kWorld };

// derived: the largest page of a list.
inline constexpr std::size_t kMaxNames = 10'000;

// At most kMaxNames; empty if the server does not answer within half a second.
std::vector<std::string> KnownNames(const Session& session, NameKind kind);

}  // namespace cwm::cli
