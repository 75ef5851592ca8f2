// The sender of a request: its connection, and the user at the other end.
#pragma once

#include <cstdint>
#include <optional>

namespace cwm::server {

struct ClientId {
  // Connections are numbered from 1 in the order of acceptance; numbers are never reused. 0 is this
  // process itself (the viewer's calls). kClosed is a connection that was closed before its call
  // was examined.
  static constexpr std::int64_t kClosed = -1;
  std::int64_t connection = 0;
  // The user id that the kernel reports for the peer; empty if it reports none.
  std::optional<std::uint32_t> uid = {};

  friend bool operator==(const ClientId&, const ClientId&) = default;
};

}  // namespace cwm::server
