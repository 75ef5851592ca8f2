// Addresses that the server may listen at: a Unix socket, or loopback. Others would need TLS, which
// the server does not support yet.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace cwm::server {

// Checks "unix:PATH" or "HOST:PORT" and returns it. InvalidArgument for another form and for a host
// that is not loopback (127.0.0.0/8, ::1, localhost).
absl::StatusOr<std::string> CheckListenAddress(const std::string& address);

// The path of "unix:PATH"; empty for other addresses.
std::optional<std::string> SocketPath(const std::string& address);

// OK if a Unix socket can be created at the path: nothing is there, or a socket on which nobody
// answers. AlreadyExists if a server answers there, with its process; FailedPrecondition if the
// path is not a socket, or is a socket of another user that only root or its owner may replace. OK
// for addresses that are not Unix sockets. The caller holds the SocketLock of the path until it
// listens there, since a socket on which nobody answers may have just been created.
absl::Status CheckVacant(const std::string& address);

// The address to bind instead of `address`: for a Unix socket a temporary name beside its path,
// otherwise the address itself. So a socket at the path always listens.
std::string BindingAddress(const std::string& address);
// Renames the socket that was bound for an address to its path, replacing one on which nobody
// answers; the path is never empty in between. Unavailable if the file system refuses.
absl::Status MoveIntoPlace(const std::string& bound, const std::string& address);

// Identifies the file of a path. Inode numbers are reused, their change times are not.
struct SocketFile {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  std::int64_t changed_s = 0;
  std::int64_t changed_ns = 0;
  friend bool operator==(const SocketFile&, const SocketFile&) = default;
};
// The socket at a Unix socket's path; empty for other addresses and if there is none.
std::optional<SocketFile> FindSocket(const std::string& address);
// Removes the socket file of a server that stopped, unless another server's socket is there by now
// or one is being created. Takes the SocketLock.
void RemoveSocket(const std::string& address, const SocketFile& own);

}  // namespace cwm::server
