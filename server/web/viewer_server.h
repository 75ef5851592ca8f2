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
  // What who looks has to know; empty: a random one where others than this machine can connect,
  // else none, and only this process's user and root may look. The rule: IsToken of access.h.
  std::string token = {};
  PageFiles files = {};
  ViewerLimits limits = {};
};

// Shows and changes nothing. One thread of its own moves messages; the services compute on theirs.
class ViewerServer {
 public:
  // `services`: a channel to the services of this process. InvalidArgument for a token that breaks
  // the rule, AlreadyExists for an address where somebody listens, Unavailable for one that cannot
  // be had otherwise.
  static absl::StatusOr<std::unique_ptr<ViewerServer>> Start(
      const ViewerOptions& options, const std::shared_ptr<grpc::Channel>& services);
  ~ViewerServer();  // stops

  // What users open, at least one: with the port that was picked in the place of 0, and the token
  // if one is needed.
  const std::vector<std::string>& urls() const;

  // Sockets are closed with "going away"; returns when all has ended, within some seconds. The
  // services must still be there.
  void Stop();

 private:
  struct State;
  explicit ViewerServer(std::unique_ptr<State> state);
  const std::unique_ptr<State> state_;
};

}  // namespace cwm::server
