// Accepts connections on a thread of its own, and keeps going whatever clients do and however few
// descriptors are left.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/core/file_descriptor.h"
#include "server/rpc/connections.h"

namespace cwm::server {

// Needed since gRPC 1.51's own listener never accepts again once it has run out of descriptors,
// keeps a transport for each silent peer, and does not report who the peer is.
//
// A connection is handed over once the beginning of HTTP/2 can be read from it (the preface and the
// header of the first SETTINGS frame), which is left in the socket. A connection that begins
// differently is closed at once; one that stays silent is closed after max_silence. A connection
// above a limit of `connections` evicts the user's connection that has been silent longest, or is
// closed itself. If there is no descriptor for it, it is closed at once, and the loop pauses for a
// moment.
//
// Thread safe.
class AcceptLoop {
 public:
  // Takes ownership of the descriptor of a registered connection. Called on the loop's thread.
  using HandOver = std::function<void(int descriptor)>;
  // True if the user may have the connection; otherwise it is closed at once. Called on the loop's
  // thread.
  using Allows = std::function<bool(int descriptor, Connections::User user)>;

  // Unavailable if the descriptors that the loop needs itself are not available.
  static absl::StatusOr<std::unique_ptr<AcceptLoop>> Start(std::vector<FileDescriptor> listeners,
                                                           Connections& connections,
                                                           std::chrono::milliseconds max_silence,
                                                           HandOver hand_over, Allows allows = {});
  ~AcceptLoop();  // stops

  // Admits the connection from this address (a sockaddr, bytewise) above every limit, for the
  // server's own check of itself. Replaces the previous address; empty: none.
  void ExemptPeer(std::string peer_address);

  // Accepts the connections made so far and closes the listeners; after it returns, nobody can
  // connect. Connections that are still silent may go on.
  void StopListening();
  // Also closes silent connections; after it returns, no connection is handed over.
  void Stop();

 private:
  struct State;
  explicit AcceptLoop(std::unique_ptr<State> state);
  const std::unique_ptr<State> state_;
};

}  // namespace cwm::server
