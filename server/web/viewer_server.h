// The viewer: HTTP and WebSocket on a port of its own, in front of the services of this process.
#pragma once

#include <grpcpp/channel.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/web/page_files.h"
#include "server/web/viewer_address.h"
#include "server/web/viewer_limits.h"

namespace cwm::server {

struct ViewerOptions {
  ViewerAddress address;
  // The secret that viewers must know. If empty, a random one is used when other machines can
  // connect; on loopback none is needed, but only this process's user and root may view. The rule:
  // IsToken of access.h.
  std::string token = {};
  PageFiles files = {};
  ViewerLimits limits = {};
};

// Displays worlds and changes nothing. One thread of its own moves messages; the services compute
// on theirs.
class ViewerServer {
 public:
  // `services`: a channel to the services of this process. InvalidArgument for a token that breaks
  // the rule, AlreadyExists for an address that is in use, Unavailable if listening fails for
  // another reason.
  static absl::StatusOr<std::unique_ptr<ViewerServer>> Start(
      const ViewerOptions& options, const std::shared_ptr<grpc::Channel>& services);
  ~ViewerServer();  // stops

  // The addresses for users to open, at least one, with the port that was picked instead of 0 and
  // the token if one is needed.
  const std::vector<std::string>& urls() const;

  // Closes all sockets with "going away". Returns when all has ended, within a few seconds. The
  // services must still exist.
  void Stop();

 private:
  struct State;
  explicit ViewerServer(std::unique_ptr<State> state);
  const std::unique_ptr<State> state_;
};

}  // namespace cwm::server
