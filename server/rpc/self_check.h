// Whether a server answers, seen from outside.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "absl/status/status.h"

namespace cwm::server {

// Connects to the address ("unix:PATH" or "HOST:PORT" of loopback), over a connection of its own,
// and asks the standard health service. OK when it says SERVING within `timeout`. `announce` is
// told the address of the own end (a sockaddr, bytewise) before it connects.
absl::Status CheckHealth(const std::string& address, std::chrono::milliseconds timeout,
                         const std::function<void(std::string)>& announce = nullptr);

}  // namespace cwm::server
