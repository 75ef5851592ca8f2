// Sends a blob by its hash as it is read, so that at most one chunk is in memory.
#pragma once

#include <boost/beast/core/tcp_stream.hpp>
#include <functional>
#include <optional>
#include <string>

#include "server/web/viewer_context.h"

namespace cwm::server {

class BlobReply {
 public:
  struct Request {
    const HttpRequest& http;
    std::string hash;
  };
  struct Outcome {
    std::optional<HttpReply> refusal = {};  // to be sent, since nothing was sent yet
    bool keep_alive = false;
  };
  // `stream` must live until `done`, which is called once, on the viewer's thread.
  static void Start(boost::beast::tcp_stream& stream, ViewerContext& viewer, const Request& request,
                    std::function<void(Outcome)> done);
};

}  // namespace cwm::server
