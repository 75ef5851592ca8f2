// What connections may cost. GetServerInfo publishes those that a client plans by.
#pragma once

#include <chrono>
#include <cstdint>

namespace cwm::server {

struct TransportLimits {
  // At a time, each with one descriptor of the process; fitted to the descriptors that it may have
  // (ConnectionLimits::Fit). A user may have half of all: none keeps the others out.
  std::int64_t max_connections = 4'096;
  std::int64_t max_connections_of_user = 2'048;
  // Connections that have not begun to speak. A client speaks within milliseconds: so many come in
  // at once, and the one that is silent for longest makes room for the next.
  std::int64_t max_silent_connections = 256;
  std::chrono::milliseconds max_silence = std::chrono::seconds(10);  // of a new connection
  // An idle connection is noticed as dead within 40 s.
  std::chrono::milliseconds keepalive_time = std::chrono::seconds(30);
  std::chrono::milliseconds keepalive_timeout = std::chrono::seconds(10);
};

}  // namespace cwm::server
