// The connections that the server holds: how many each user may have, and whose each call is.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <unordered_map>

#include "server/core/client_id.h"
#include "server/core/limits.h"
#include "server/rpc/file_descriptor.h"
#include "server/rpc/transport_limits.h"

namespace cwm::server {

// How many connections may be open. All that the kernel reports no user for are of one user.
struct ConnectionLimits {
  std::int64_t all = 0;
  std::int64_t of_user = 0;
  std::int64_t silent_of_user = 0;  // of them, those that have not begun to speak HTTP/2

  // Those of `limits`, made smaller where the process may have few descriptors: connections take
  // half of them, one user half of that.
  static ConnectionLimits Fit(const TransportLimits& limits, std::int64_t max_descriptors);
};

// The descriptors that this process may have: the soft limit.
std::int64_t MaxDescriptors();

// Thread safe. gRPC names the peer of a connection that was handed to it by the number of its
// descriptor, and tells nobody when it closes it. So each gets a number that no other had for long,
// and is known to be closed when another file, or none, lies at the number.
class Connections {
 public:
  using User = std::optional<std::uint32_t>;

  Connections(ConnectionLimits limits, std::int64_t max_descriptors);

  // Counts one more connection of the user; false when there are too many, of the user or in all.
  bool TryAdmit(User user);
  void AdmitAlways(User user);
  // Of one that was admitted and is closed without having been registered.
  void Forget(User user);

  // Gives an admitted connection its final number and returns it; who takes it closes it. It is
  // counted until then.
  int Register(FileDescriptor connection, User user);

  // The client at a number: Closed when its connection is no longer there.
  ClientId Find(int number) const;

  // Forgets what was closed.
  void Sweep();
  // shutdown(2) on all that are open.
  void ShutDown(int how) const;

  void CountShed(std::int64_t count = 1) { shed_ += count; }

  const ConnectionLimits& limits() const { return limits_; }
  std::int64_t open() const;                   // admitted ones that are not registered included
  std::int64_t shed() const { return shed_; }  // closed by the server before they were registered

 private:
  struct Entry {
    ClientId client;
    std::uint64_t device = 0;
    std::uint64_t inode = 0;
  };
  static bool IsOpen(int number, const Entry& entry);
  bool HasRoom(User user) const;
  void Count(User user);
  void Discount(User user);
  void SweepLocked();
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
  Clock::time_point swept_at_ = {};
};

}  // namespace cwm::server
