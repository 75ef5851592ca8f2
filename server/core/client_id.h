// Who sends a request: the connection that it comes over, and the user at its other end.
#pragma once

#include <cstdint>
#include <optional>

namespace cwm::server {

struct ClientId {
  // Connections are numbered from 1 in the order in which they are accepted; a number is never
  // given twice. 0 is this process itself: the viewer's calls. kClosed is one that was closed
  // before its call could be looked at.
  static constexpr std::int64_t kClosed = -1;
  std::int64_t connection = 0;
  // The user id that the kernel reports for the peer; absent where it reports none.
  std::optional<std::uint32_t> uid = {};

  friend bool operator==(const ClientId&, const ClientId&) = default;
};

}  // namespace cwm::server
