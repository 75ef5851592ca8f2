// What systemd is told of the server (sd_notify(3)), where it asks for it. Its protocol is one
// datagram; the library that sends it would bring four others into the process.
#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace cwm::server {

// Sends a state such as "READY=1" to the socket that NOTIFY_SOCKET names. False where there is none
// or it does not take it. Thread safe.
bool NotifyServiceManager(const std::string& state);

// Within this time after the last "WATCHDOG=1" the next has to come; absent where nobody waits for
// it (WATCHDOG_USEC and, where given, WATCHDOG_PID).
std::optional<std::chrono::microseconds> WatchdogTime();

}  // namespace cwm::server
