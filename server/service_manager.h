// Notifies systemd of the server's state (sd_notify(3)) if systemd asks for it. The protocol is one
// datagram; libsystemd would bring four other libraries into the process.
#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace cwm::server {

// Sends a state such as "READY=1" to the socket that NOTIFY_SOCKET names. False if there is no such
// socket or it does not accept the datagram. Thread safe.
bool NotifyServiceManager(const std::string& state);

// The longest time between two "WATCHDOG=1" notifications; empty if no service manager waits for
// them (WATCHDOG_USEC and, if set, WATCHDOG_PID).
std::optional<std::chrono::microseconds> WatchdogTime();

}  // namespace cwm::server
