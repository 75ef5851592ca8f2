// Limits of connections. GetServerInfo publishes those that clients need to know.
#pragma once

#include <chrono>
#include <cstdint>

namespace cwm::server {

struct TransportLimits {
  // Simultaneous connections, each with one descriptor of the process; reduced to the available
  // descriptors (ConnectionLimits::Fit). A user may have half of them, so that nobody excludes
  // others.
  std::int64_t max_connections = 4'096;
  std::int64_t max_connections_of_user = 2'048;
  // Connections that have not sent anything yet. A client does so within milliseconds; if more
  // connect at once, the one that has been silent longest is closed.
  std::int64_t max_silent_connections = 256;
  std::chrono::milliseconds max_silence = std::chrono::seconds(10);  // of a new connection
  // A dead idle connection is detected within 40 s.
  std::chrono::milliseconds keepalive_time = std::chrono::seconds(30);
  std::chrono::milliseconds keepalive_timeout = std::chrono::seconds(10);
};

}  // namespace cwm::server
