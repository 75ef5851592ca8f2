// Maps a request to its reply: the page, a blob, the WebSocket, or a refusal. Depends only on the
// request and its user.
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

  struct OpenSocket {};  // or a refusal, depending on the Upgrade header
  struct ReadBlob {
    std::string hash;  // 64 lower-case hex digits
  };
  using Route = std::variant<HttpReply, OpenSocket, ReadBlob>;
  // `uid`: the user who sends the request, if the kernel reports it.
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

// A line of text for people. Every reply has the headers that isolate the page from others.
HttpReply TextReply(const HttpRequest& request, http::status status, std::string_view text);
// True for methods that only read; MethodRefusal is the reply to others.
bool IsReadMethod(const HttpRequest& request);
HttpReply MethodRefusal(const HttpRequest& request);
// The reply to a request for the socket's path that is not a WebSocket upgrade.
HttpReply UpgradeRefusal(const HttpRequest& request);
void SetSecurityHeaders(http::fields& fields);
// Sets the length, and drops the body of a reply to HEAD.
void FinishReply(const HttpRequest& request, HttpReply& reply);

}  // namespace cwm::server
