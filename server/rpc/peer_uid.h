// The user at the other end of a connection.
#pragma once

#include <cstdint>
#include <optional>

namespace cwm::server {

// The user id that the kernel reports for the peer of a connected socket; for a Unix socket the
// peer's user when it connected. Empty if the kernel reports none, as for TCP.
std::optional<std::uint32_t> PeerUid(int descriptor);

}  // namespace cwm::server
