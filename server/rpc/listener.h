// Sockets that listen at an address.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/rpc/file_descriptor.h"

namespace cwm::server {

struct ListeningSockets {
  std::string address;                  // as a client dials it
  std::vector<FileDescriptor> sockets;  // non-blocking, closed on exec
};

// Listens at an address that CheckListenAddress takes. "localhost" is both loopback addresses of
// the machine on one port; port 0 picks one. The socket file of "unix:PATH" has mode 0600 and comes
// into place when it listens; the caller holds its SocketLock and knows that it is vacant. Data
// that a TCP client does not acknowledge for `user_timeout` ends its connection. Unavailable, with
// the address and the reason, when it cannot be had.
absl::StatusOr<ListeningSockets> Listen(const std::string& address,
                                        std::chrono::milliseconds user_timeout);

}  // namespace cwm::server
