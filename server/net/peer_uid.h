// The user at the other end of a connection from this machine.
#pragma once

#include <cstdint>
#include <optional>

namespace cwm::server {

// The user id of the process that owns the peer of a connected socket, as this process's user
// namespace sees it. For a Unix socket it is the user that connected; for a TCP connection over
// loopback (IPv4, IPv6, IPv4 over a socket of IPv6) the user that made the peer's socket. Absent
// when the peer is elsewhere or has closed its socket, and when the kernel does not report it
// within 100 ms. Takes less than 0.1 ms. Thread-safe.
std::optional<std::uint32_t> PeerUid(int fd);

}  // namespace cwm::server
