// The gRPC server: all services on the given addresses, until it is drained.
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
  // Listens on each of "unix:PATH" or "HOST:PORT" (see listen_address.h; port 0 picks one); sockets
  // are the user's alone (mode 0600), and so are ports unless `listen` allows any local user.
  // `application` outlives the server.
  static absl::StatusOr<std::unique_ptr<Server>> Start(Application& application,
                                                       const ListenOptions& listen);
  ~Server();  // Stop(0)

  // As a client takes them.
  const std::vector<std::string>& addresses() const;

  // To the same services without a socket, for what runs in this process. Messages of any size.
  std::shared_ptr<grpc::Channel> InProcessChannel() const;

  // OK when the server answers on its first address, over a connection of its own that no limit
  // refuses, within `timeout` that it serves. Not beside Stop.
  absl::Status CheckItself(std::chrono::milliseconds timeout) const;

  // Health says NOT_SERVING, nobody connects any more, watches end with a bookmark, streams and
  // half-open uploads end, calls that wait for their turn and those to come are refused, calls
  // under way finish or are stopped after `grace`: all that do not finish end with SERVER_DRAINING.
  // Then the connections are closed. Returns when all has ended.
  void Stop(std::chrono::milliseconds grace);

 private:
  struct State;
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cwm::server
