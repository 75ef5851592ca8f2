// A blob by its hash, sent as it is read: never more than a chunk of it is held.
#pragma once

#include <boost/beast/core/tcp_stream.hpp>
#include <functional>
#include <optional>
#include <string>

#include "server/web/house.h"

namespace cwm::server {

class BlobReply {
 public:
  struct Question {
    const HttpRequest& request;
    std::string hash;
  };
  struct Outcome {
    std::optional<HttpReply> refusal = {};  // to be sent: nothing was yet
    bool keep_alive = false;
  };
  // `stream` lives until `done`, which is called once, on the viewer's thread.
  static void Start(boost::beast::tcp_stream& stream, House& house, const Question& question,
                    std::function<void(Outcome)> done);
};

}  // namespace cwm::server
