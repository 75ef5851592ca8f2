// What a request gets: the page, a blob, the socket, or why not. A function of the request and its
// user alone.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "server/web/access.h"
#include "server/web/http_types.h"
#include "server/web/page_files.h"

namespace cwm::server {

class Site {
 public:
  Site(Access access, const PageFiles& files);

  struct OpenSocket {};  // or say why not, whoever asks
  struct ReadBlob {
    std::string hash;  // 64 lower-case hex digits
  };
  using Route = std::variant<HttpReply, OpenSocket, ReadBlob>;
  // `uid`: the user who asks, where the kernel reports it.
  Route RouteOf(const HttpRequest& request, std::optional<std::uint32_t> uid) const;

  const Access& access() const { return access_; }

 private:
  struct File {
    std::string_view path;
    std::string_view type;
    PageFile file;
    std::string etag;  // without quotes
  };
  HttpReply ReplyOf(const HttpRequest& request, const File& file) const;

  const Access access_;
  std::vector<File> files_;
};

// A line of text for people; every reply has the headers that keep the page to itself.
HttpReply TextReply(const HttpRequest& request, http::status status, std::string_view text);
// Methods that only read; of others, the reply.
bool IsReading(const HttpRequest& request);
HttpReply MethodRefusal(const HttpRequest& request);
// Of who asks for the socket and for no WebSocket.
HttpReply UpgradeRefusal(const HttpRequest& request);
void SetSafetyHeaders(http::fields& fields);
// Sets the length; a reply to HEAD loses its body.
void Seal(const HttpRequest& request, HttpReply& reply);

}  // namespace cwm::server
