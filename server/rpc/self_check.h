// Checks from outside that a server answers.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "absl/status/status.h"

namespace cwm::server {

// Connects to the address ("unix:PATH" or "HOST:PORT" of loopback) over a new connection and
// queries the standard health service. OK if it reports SERVING within `timeout`. `announce` is
// called with the address of our end (a sockaddr, bytewise) before it connects.
absl::Status CheckHealth(const std::string& address, std::chrono::milliseconds timeout,
                         const std::function<void(std::string)>& announce = nullptr);

}  // namespace cwm::server
