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
  // Listens on each of the addresses; sockets are the user's alone (mode 0600; sets the process's
  // umask for a moment, so start it before other threads make files). `application` outlives the
  // server.
  static absl::StatusOr<std::unique_ptr<Server>> Start(Application& application,
                                                       const ListenOptions& listen);
  ~Server();  // Stop(0)

  // As a client takes them.
  const std::vector<std::string>& addresses() const;

  // To the same services without a socket, for what runs in this process. Messages of any size.
  std::shared_ptr<grpc::Channel> InProcessChannel() const;

  // Health says NOT_SERVING, no new upload begins, watches end with a bookmark, streams end, calls
  // under way finish; what is not done after `grace` is cancelled. Returns when all has ended.
  void Stop(std::chrono::milliseconds grace);

 private:
  struct State;
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cwm::server
