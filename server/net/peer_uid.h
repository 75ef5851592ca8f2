// The user at the other end of a local connection.
#pragma once

#include <cstdint>
#include <optional>

namespace cwm::server {

// The user id of the process that owns the peer of a connected socket, in this process's user
// namespace. For a Unix socket it is the user that connected; for a TCP connection over loopback
// (IPv4, IPv6, IPv4 over an IPv6 socket), the user that created the peer's socket. Empty if the
// peer is on another machine or has closed its socket, or if the kernel does not report the user
// within 100 ms. Takes less than 0.1 ms. Thread safe.
std::optional<std::uint32_t> PeerUid(int fd);

}  // namespace cwm::server
