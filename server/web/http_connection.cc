#include "server/web/http_connection.h"

#include <boost/beast/http/error.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/web/blob_reply.h"
#include "server/web/socket_session.h"

namespace cwm::server {
namespace {

using boost::beast::error_code;

// chosen: a reply is written in pieces, each with its own timeout, since a file of the page may
// take long on a slow line.
constexpr std::size_t kBodyPieceBytes = 64 << 10;

}  // namespace

HttpConnection::HttpConnection(boost::asio::ip::tcp::socket socket,
                               std::optional<std::uint32_t> uid, ViewerContext& viewer)
    : Connection(viewer.connections, uid), viewer_(viewer), stream_(std::move(socket)) {}

void HttpConnection::ReadRequest() {
  parser_.emplace();
  parser_->header_limit(viewer_.limits.header_bytes);
  parser_->body_limit(0);
  idle_ = true;
  stream_.expires_after(viewer_.limits.http_idle_timeout);
  http::async_read(
      stream_, buffer_, *parser_,
      [self = shared_from_this()](error_code error, std::size_t) { self->OnRequest(error); });
}

void HttpConnection::OnRequest(error_code error) {
  idle_ = false;
  if (viewer_.connections.closed) return Close();
  if (error) return RefuseMalformed(error);
  auto route = viewer_.site.RouteOf(parser_->get(), uid());
  if (auto* reply = std::get_if<HttpReply>(&route)) return Send(std::move(*reply));
  if (const auto* blob = std::get_if<Site::ReadBlob>(&route)) return ReadBlob(blob->hash);
  OpenSocket();
}

// A failure of the connection ends it; a malformed request is answered first.
void HttpConnection::RefuseMalformed(error_code error) {
  if (error.category() != http::make_error_code(http::error::bad_version).category() ||
      error == http::error::end_of_stream || error == http::error::partial_message) {
    return Close();
  }
  http::status status = http::status::bad_request;
  std::string why = absl::StrCat("request: ", error.message());
  if (error == http::error::header_limit) {
    status = http::status::request_header_fields_too_large;
    why = absl::StrCat("header: must have at most ", viewer_.limits.header_bytes, " bytes");
  } else if (error == http::error::body_limit || error == http::error::unexpected_body) {
    status = http::status::payload_too_large;
    why = "body: must be empty";
  }
  HttpReply reply = status == http::status::payload_too_large && !IsReadMethod(parser_->get())
                        ? MethodRefusal(parser_->get())
                        : TextReply({}, status, why);
  reply.keep_alive(false);
  Send(std::move(reply));
}

void HttpConnection::Send(HttpReply reply) {
  serializer_.reset();
  reply_ = std::move(reply);
  serializer_.emplace(reply_);
  serializer_->limit(kBodyPieceBytes);
  WritePiece();
}

void HttpConnection::WritePiece() {
  stream_.expires_after(viewer_.limits.write_timeout);
  http::async_write_some(stream_, *serializer_,
                         [self = shared_from_this()](error_code error, std::size_t) {
                           if (!error && !self->serializer_->is_done()) return self->WritePiece();
                           self->OnReplySent(!error && self->reply_.keep_alive());
                         });
}

void HttpConnection::OpenSocket() {
  if (viewer_.connections.sockets >= viewer_.limits.sockets) {
    HttpReply reply = TextReply(parser_->get(), http::status::service_unavailable,
                                absl::StrCat("socket: there are ", viewer_.limits.sockets,
                                             " already, must be at most as many"));
    reply.set(http::field::retry_after, "10");
    return Send(std::move(reply));
  }
  if (!boost::beast::websocket::is_upgrade(parser_->get())) {
    return Send(UpgradeRefusal(parser_->get()));
  }
  std::make_shared<SocketSession>(stream_.release_socket(), uid(), viewer_)
      ->Accept(parser_->release());
}

void HttpConnection::ReadBlob(const std::string& hash) {
  BlobReply::Start(stream_, viewer_, {.http = parser_->get(), .hash = hash},
                   [self = shared_from_this()](BlobReply::Outcome outcome) {
                     if (outcome.refusal) return self->Send(*std::move(outcome.refusal));
                     self->OnReplySent(outcome.keep_alive);
                   });
}

void HttpConnection::OnReplySent(bool keep_alive) {
  if (viewer_.connections.closed) return Close();
  if (keep_alive) return ReadRequest();
  error_code error;
  stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, error);
  if (error) return Close();
  stream_.expires_after(viewer_.limits.close_timeout);
  DrainInput();
}

// Reads and discards input, since closing a connection with unread bytes resets it, and the reply
// may be lost.
void HttpConnection::DrainInput() {
  stream_.async_read_some(boost::asio::buffer(discarded_),
                          [self = shared_from_this()](error_code error, std::size_t) {
                            if (error) return self->Close();
                            self->DrainInput();
                          });
}

void HttpConnection::Close() {
  idle_ = false;
  stream_.close();
}

}  // namespace cwm::server
