// All that a server tells of its worlds, as digests.
#pragma once

#include <map>
#include <string>

#include "clients/cpp/connection.h"

namespace cwm::fault {

// The digest of each answer by what was asked, such as "main objects" or "main watch". An answer
// that is refused is "refused: REASON".
using Fingerprint = std::map<std::string, std::string>;

Fingerprint FingerprintOf(const client::Connection& connection);

inline constexpr char kRefused[] = "refused: ";

}  // namespace cwm::fault
