// The open connections of the server: how many each user may have, and which client each call comes
// from.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <unordered_map>

#include "server/core/client_id.h"
#include "server/core/file_descriptor.h"
#include "server/core/limits.h"
#include "server/rpc/transport_limits.h"

namespace cwm::server {

// The most connections that may be open. All connections whose user the kernel does not report
// count as one user's.
struct ConnectionLimits {
  std::int64_t all = 0;
  std::int64_t of_user = 0;
  std::int64_t silent_of_user = 0;  // those that have not begun to speak HTTP/2

  // The limits of `limits`, reduced if the process may have few descriptors: connections take at
  // most half of them, one user half of that.
  static ConnectionLimits Fit(const TransportLimits& limits, std::int64_t max_descriptors);
};

// The number of descriptors that this process may have: the soft limit.
std::int64_t MaxDescriptors();

// Thread safe. gRPC names the peer of a connection that was handed to it by its descriptor, and
// does not report when it closes it. So each connection gets a descriptor number that was not used
// for long, and counts as closed when another file, or none, has that number.
class Connections {
 public:
  using User = std::optional<std::uint32_t>;

  Connections(ConnectionLimits limits, std::int64_t max_descriptors);

  // Counts one more connection of the user; false if there are too many, of the user or in total.
  bool TryAdmit(User user);
  void AdmitAlways(User user);
  // Uncounts an admitted connection that was closed without being registered.
  void CancelAdmission(User user);

  // Moves an admitted connection to its final number and returns it; the caller is responsible for
  // closing it. It counts until it is closed.
  int Register(FileDescriptor connection, User user);

  // The client of a number; ClientId::kClosed if its connection is no longer open.
  ClientId Find(int number) const;

  // Drops the entries of closed connections.
  void DropClosed();
  // Calls shutdown(2) on all open connections.
  void ShutDown(int how) const;

  void CountShed(std::int64_t count = 1) { shed_ += count; }

  const ConnectionLimits& limits() const { return limits_; }
  std::int64_t open() const;                   // includes unregistered ones
  std::int64_t shed() const { return shed_; }  // closed before registration

 private:
  struct Entry {
    ClientId client;
    std::uint64_t device = 0;
    std::uint64_t inode = 0;
  };
  static bool IsOpen(int number, const Entry& entry);
  bool HasRoom(User user) const;
  void Count(User user);
  void Uncount(User user);
  void DropClosedLocked();
  int MoveToFreshNumber(FileDescriptor connection);

  const ConnectionLimits limits_;
  const int first_number_;
  const int end_number_;
  std::atomic<std::int64_t> shed_ = 0;

  mutable std::mutex mutex_;
  int next_number_;
  std::int64_t last_connection_ = 0;
  std::int64_t open_ = 0;
  std::map<User, std::int64_t> open_of_;
  std::unordered_map<int, Entry> entries_;  // by number
  Clock::time_point last_sweep_ = {};
};

}  // namespace cwm::server
