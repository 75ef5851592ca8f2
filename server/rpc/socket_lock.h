// Ensures that one server at a time starts on a Unix socket: between checking whether another
// server answers there and listening there, no other server may do the same.
#pragma once

#include <string>

#include "absl/status/statusor.h"

namespace cwm::server {

// Holds PATH.lock, a file beside the socket, for that time only. The kernel releases the lock of a
// process that dies. It is not held for a server's whole life: a running server is recognised by
// its answer on the socket.
class SocketLock {
 public:
  // Waits while another server starts, which takes milliseconds. Unavailable with its process id if
  // that takes seconds; FailedPrecondition if the lock file cannot be created, or if an existing
  // one belongs to another user or is not a lock file: its owner could hold it for ever, and it is
  // not written to.
  static absl::StatusOr<SocketLock> Acquire(const std::string& socket_path);

  SocketLock(SocketLock&& other) noexcept;
  SocketLock& operator=(SocketLock&&) = delete;
  ~SocketLock();

 private:
  SocketLock(std::string path, int fd);

  std::string path_;  // of the lock file
  int fd_;            // -1: moved from
};

}  // namespace cwm::server
