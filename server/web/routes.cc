#include "server/web/routes.h"

#include <algorithm>
#include <boost/beast/http/rfc7230.hpp>
#include <optional>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "proto/transfer/sha256.h"

namespace cwm::server {
namespace {

constexpr std::string_view kBlobPathPrefix = "/geometry/";
constexpr std::size_t kHashDigits = 64;
constexpr std::size_t kEtagDigits = 32;

bool IsHash(std::string_view text) {
  return text.size() == kHashDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

boost::beast::string_view Beast(std::string_view text) { return {text.data(), text.size()}; }

// True if Accept-Encoding names gzip, and not with q=0.
bool AcceptsGzip(const HttpRequest& request) {
  const http::ext_list codings(request[http::field::accept_encoding]);
  for (const auto& [name, parameters] : codings) {
    if (!absl::EqualsIgnoreCase(absl::string_view(name.data(), name.size()), "gzip")) continue;
    for (const auto& [key, value] : parameters) {
      double quality = 1;
      if (key != "q") continue;
      return absl::SimpleAtod(absl::string_view(value.data(), value.size()), &quality) &&
             quality > 0;
    }
    return true;
  }
  return false;
}

// Allows the page only its own scripts, styles and connections. `host` must have been checked.
std::string ContentSecurityPolicy(std::string_view host) {
  return absl::StrCat(
      "default-src 'none'; script-src 'self'; style-src 'self'; worker-src 'self'; "
      "connect-src 'self' ws://",
      absl::string_view(host.data(), host.size()),
      "; img-src 'self' blob: data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
}

}  // namespace

Site::Site(Access access, const PageFiles& files) : access_(std::move(access)) {
  constexpr std::string_view kScript = "text/javascript; charset=utf-8";
  for (File file : {File{"/", "text/html; charset=utf-8", files.page, {}},
                    File{"/viewer.js", kScript, files.script, {}},
                    File{"/worker.js", kScript, files.worker, {}},
                    File{"/style.css", "text/css; charset=utf-8", files.style, {}}}) {
    if (file.file.bytes.empty()) continue;
    file.etag = Sha256Hex(file.file.bytes).substr(0, kEtagDigits);
    files_.push_back(std::move(file));
  }
}

Site::Route Site::RouteOf(const HttpRequest& request, std::optional<std::uint32_t> uid) const {
  if (const auto refusal = access_.CheckUser(uid)) {
    HttpReply reply = TextReply(request, refusal->status, refusal->why);
    reply.keep_alive(false);  // its next requests would be refused as well
    return reply;
  }
  if (const auto refusal = access_.CheckHost(request)) {
    return TextReply(request, refusal->status, refusal->why);
  }
  if (!IsReadMethod(request)) return MethodRefusal(request);
  if (const auto refusal = access_.CheckToken(request)) {
    return TextReply(request, refusal->status, refusal->why);
  }
  const std::string_view path =
      PathOf(std::string_view(request.target().data(), request.target().size()));
  for (const File& file : files_) {
    if (path == file.path) return ReplyOf(request, file);
  }
  if (path == "/socket") {
    if (const auto refusal = Access::CheckOrigin(request)) {
      return TextReply(request, refusal->status, refusal->why);
    }
    return OpenSocket{};
  }
  if (path.substr(0, kBlobPathPrefix.size()) == kBlobPathPrefix) {
    const std::string_view hash = path.substr(kBlobPathPrefix.size());
    if (IsHash(hash)) return ReadBlob{std::string(hash)};
    return TextReply(request, http::status::bad_request,
                     "hash: must be the 64 lower-case hex digits of a SHA-256");
  }
  return TextReply(request, http::status::not_found, "path: there is no such page");
}

HttpReply Site::ReplyOf(const HttpRequest& request, const File& file) const {
  const bool is_gzip = !file.file.gzip.empty() && AcceptsGzip(request);
  const std::string etag = absl::StrCat("\"", file.etag, is_gzip ? "-gzip" : "", "\"");
  const bool is_known = request[http::field::if_none_match] == Beast(etag);
  HttpReply reply(is_known ? http::status::not_modified : http::status::ok, request.version());
  SetSecurityHeaders(reply);
  reply.set(http::field::cache_control, "no-cache");
  reply.set(http::field::etag, etag);
  if (!file.file.gzip.empty()) reply.set(http::field::vary, "Accept-Encoding");
  if (const auto cookie = access_.CookieFor(request)) {
    reply.set(http::field::set_cookie, *cookie);
    reply.set(http::field::cache_control, "no-store");
  }
  if (!is_known) {
    reply.set(http::field::content_type, Beast(file.type));
    const auto host = request[http::field::host];
    reply.set("Content-Security-Policy", ContentSecurityPolicy({host.data(), host.size()}));
    if (is_gzip) reply.set(http::field::content_encoding, "gzip");
    reply.body().file = is_gzip ? file.file.gzip : file.file.bytes;
  }
  FinishReply(request, reply);
  return reply;
}

HttpReply TextReply(const HttpRequest& request, http::status status, std::string_view text) {
  HttpReply reply(status, request.version() == 0 ? 11 : request.version());
  SetSecurityHeaders(reply);
  reply.set("Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'");
  reply.set(http::field::cache_control, "no-store");
  reply.set(http::field::content_type, "text/plain; charset=utf-8");
  reply.body().text = std::string(text) + "\n";
  FinishReply(request, reply);
  return reply;
}

bool IsReadMethod(const HttpRequest& request) {
  return request.method() == http::verb::get || request.method() == http::verb::head;
}

HttpReply MethodRefusal(const HttpRequest& request) {
  HttpReply reply = TextReply(request, http::status::method_not_allowed,
                              "method: must be GET or HEAD, nothing can be changed here");
  reply.set(http::field::allow, "GET, HEAD");
  return reply;
}

HttpReply UpgradeRefusal(const HttpRequest& request) {
  HttpReply reply =
      TextReply(request, http::status::upgrade_required, "Upgrade: must be websocket, version 13");
  reply.set(http::field::upgrade, "websocket");
  return reply;
}

void SetSecurityHeaders(http::fields& fields) {
  fields.set("X-Content-Type-Options", "nosniff");
  fields.set("Referrer-Policy", "no-referrer");
  fields.set("X-Frame-Options", "DENY");
  fields.set("Cross-Origin-Resource-Policy", "same-origin");
}

void FinishReply(const HttpRequest& request, HttpReply& reply) {
  reply.keep_alive(request.keep_alive());
  if (reply.result() == http::status::not_modified) return;
  const std::size_t size = reply.body().bytes().size();
  if (request.method() == http::verb::head) reply.body() = {};
  reply.content_length(size);
}

}  // namespace cwm::server
