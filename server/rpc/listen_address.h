// Where the server may listen: a Unix socket, or loopback. Anything else would need TLS, which it
// does not speak yet.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace cwm::server {

// Checks "unix:PATH" or "HOST:PORT" and returns it as gRPC takes it. InvalidArgument for another
// form and for a host that is not loopback (127.0.0.0/8, ::1, localhost).
absl::StatusOr<std::string> CheckListenAddress(const std::string& address);

// Makes room for a Unix socket at the path: removes one that nobody answers on. AlreadyExists when
// a server answers there, FailedPrecondition when the path is something other than a socket. A
// no-op for addresses that are no Unix sockets.
absl::Status ClearStaleSocket(const std::string& address);

// Removes the socket file of a server that stopped.
void RemoveSocket(const std::string& address);

}  // namespace cwm::server
