// The gRPC server: all services on the given addresses, until it is stopped.
#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/rpc/listen_options.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

class Server {
 public:
  // Listens on each "unix:PATH" or "HOST:PORT" (see listen_address.h; port 0 picks one). Sockets
  // are accessible only to this user (mode 0600), and so are ports unless `listen` allows any local
  // user. `application` must outlive the server.
  static absl::StatusOr<std::unique_ptr<Server>> Start(Application& application,
                                                       const ListenOptions& listen);
  ~Server();  // Stop(0)

  // Opens the application's gate (serving_gate.h) if it was closed: calls are served and health
  // reports SERVING from now on. Before, the server answers only GetServerInfo, GetStats, health
  // checks (NOT_SERVING) and reflection.
  void OpenGate();

  // In the form that clients dial.
  const std::vector<std::string>& addresses() const;

  // A channel to the same services without a socket, for code in this process. Messages may have
  // any size.
  std::shared_ptr<grpc::Channel> InProcessChannel() const;

  // OK if the server reports within `timeout` that it serves, on its first address and over a new
  // connection that no limit refuses. Must not run during Stop.
  absl::Status CheckItself(std::chrono::milliseconds timeout) const;

  // Reports NOT_SERVING, accepts no more connections, ends watches with a bookmark, ends streams
  // and half-open uploads, refuses waiting and later calls, and stops running calls after `grace`;
  // calls that do not finish end with SERVER_DRAINING. Then closes the connections. Returns when
  // all has ended.
  void Stop(std::chrono::milliseconds grace);

 private:
  struct State;
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cwm::server
