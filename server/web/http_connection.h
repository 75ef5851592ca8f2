// A connection of a browser, until it ends or becomes a WebSocket.
#pragma once

#include <array>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/serializer.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "server/web/viewer_context.h"

namespace cwm::server {

// Handles one request after the other. Lives as long as one of its operations is in progress.
class HttpConnection final : public Connection,
                             public std::enable_shared_from_this<HttpConnection> {
 public:
  // `uid`: the user at the other end, if the kernel reports it.
  HttpConnection(boost::asio::ip::tcp::socket socket, std::optional<std::uint32_t> uid,
                 ViewerContext& viewer);

  void ReadRequest();
  void Close() override;
  bool is_idle() const override { return idle_; }

 private:
  void OnRequest(boost::beast::error_code error);
  void RefuseMalformed(boost::beast::error_code error);
  void Send(HttpReply reply);
  void WritePiece();
  void OpenSocket();
  void ReadBlob(const std::string& hash);
  void OnReplySent(bool keep_alive);
  void DrainInput();

  ViewerContext& viewer_;
  boost::beast::tcp_stream stream_;
  boost::beast::flat_buffer buffer_;
  // Created anew for each request of the connection.
  std::optional<http::request_parser<http::empty_body>> parser_;
  HttpReply reply_;
  std::optional<http::response_serializer<ReplyBody>> serializer_;  // of reply_
  std::array<char, 4096> discarded_;
  bool idle_ = false;
};

}  // namespace cwm::server
