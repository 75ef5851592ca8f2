// Takes connections in, on a thread of its own, and goes on whatever clients and descriptors do.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/rpc/connections.h"
#include "server/rpc/file_descriptor.h"

namespace cwm::server {

// gRPC 1.51's own listener never accepts again once it has met a full table of descriptors, holds a
// transport for each silent peer, and tells nobody who the peer is.
//
// A connection is handed over once the beginning of HTTP/2 can be read from it, which is left
// there: the preface and the header of the first SETTINGS frame. A connection that begins otherwise
// is closed at once, one that is silent for too long is closed then, one that comes above a limit
// of `connections` makes the user's connection that is silent for longest go, or goes itself.
// Without a descriptor for it, it is closed at once, and the loop pauses for a moment.
//
// Thread safe.
class AcceptLoop {
 public:
  // Takes over the descriptor of a connection that is registered. Called on the loop's thread.
  using HandOver = std::function<void(int descriptor)>;
  // Tells whether the user may have the connection; others are closed at once. Called on the loop's
  // thread.
  using Allows = std::function<bool(int descriptor, Connections::User user)>;

  // Unavailable when the descriptors that it needs itself cannot be had.
  static absl::StatusOr<std::unique_ptr<AcceptLoop>> Start(std::vector<FileDescriptor> listeners,
                                                           Connections& connections,
                                                           std::chrono::milliseconds max_silence,
                                                           HandOver hand_over, Allows allows = {});
  ~AcceptLoop();  // stops

  // The connection from this address (a sockaddr, bytewise) is admitted above every limit: the
  // server's own look at itself. Replaces the address before; empty: none is.
  void Expect(std::string peer_address);

  // Takes what has connected by now and closes the listeners; when it returns, nobody connects any
  // more. Connections that are still silent may speak.
  void StopListening();
  // Also closes what is still silent; when it returns, nothing is handed over any more.
  void Stop();

 private:
  struct State;
  explicit AcceptLoop(std::unique_ptr<State> state);
  const std::unique_ptr<State> state_;
};

}  // namespace cwm::server
