// Where the server may listen: a Unix socket, or loopback. Anything else would need TLS, which it
// does not speak yet.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace cwm::server {

// Checks "unix:PATH" or "HOST:PORT" and returns it. InvalidArgument for another
// form and for a host that is not loopback (127.0.0.0/8, ::1, localhost).
absl::StatusOr<std::string> CheckListenAddress(const std::string& address);

// The path of "unix:PATH"; nothing for other addresses.
std::optional<std::string> SocketPath(const std::string& address);

// Whether a Unix socket can be put at the path: nothing is there, or a socket that nobody answers
// on. AlreadyExists when a server answers there, naming its process; FailedPrecondition when the
// path is something other than a socket, or a socket that only root or its owner, another user, may
// replace. OK for addresses that are no Unix sockets. The caller holds
// the SocketLock of the path until it listens there: what nobody answers on may be one that another
// just made.
absl::Status CheckVacant(const std::string& address);

// Where to bind in the place of an address: for a Unix socket a new name beside its path, else the
// address itself. Who finds a socket at the path finds one that listens.
std::string BindingAddress(const std::string& address);
// Moves the socket that was bound for an address to its path, in the place of one that nobody
// answers on: at no time is the path empty. Unavailable when the file system refuses.
absl::Status MoveIntoPlace(const std::string& bound, const std::string& address);

// Which file a path leads to: numbers of files are given again, their times are not.
struct SocketFile {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  std::int64_t changed_s = 0;
  std::int64_t changed_ns = 0;
  friend bool operator==(const SocketFile&, const SocketFile&) = default;
};
// The socket at a Unix socket's path; nothing for other addresses and when there is none.
std::optional<SocketFile> FindSocket(const std::string& address);
// Removes the socket file of a server that stopped, unless another server's lies there by now, or
// one is just starting there. Takes the SocketLock.
void RemoveSocket(const std::string& address, const SocketFile& own);

}  // namespace cwm::server
