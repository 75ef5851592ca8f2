// Sockets that listen at an address.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/core/file_descriptor.h"

namespace cwm::server {

struct ListeningSockets {
  std::string address;                  // as a client dials it
  std::vector<FileDescriptor> sockets;  // non-blocking, closed on exec
};

// Listens at an address that CheckListenAddress accepts. "localhost" means both loopback addresses
// on one port; port 0 picks one. The socket file of "unix:PATH" has mode 0600 and appears at its
// path when it listens; the caller holds its SocketLock and has checked that it is vacant. A TCP
// connection is closed if sent data is not acknowledged within `user_timeout`. Unavailable, with
// the address and the reason, if listening fails.
absl::StatusOr<ListeningSockets> Listen(const std::string& address,
                                        std::chrono::milliseconds user_timeout);

}  // namespace cwm::server
